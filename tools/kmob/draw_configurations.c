/* Configurations and paths of a picture. */
#include "kmob/draw.h"

#include <math.h>
#include <string.h>

enum { PATH_STEPS = 360 };

static kt_exit out_of_memory(const kmob_shots *s) {
  kt_print_message(&s->options->common, KM_ERROR, "out of memory");
  return KT_INTERNAL;
}

static kt_exit report(const kmob_shots *s, km_status status, const km_error *error) {
  if (status)
    kt_print_message(&s->options->common, KM_ERROR, "%s: %s", s->options->path, error->text);
  return kt_exit_of(status);
}

/* Keeps the pose of a state, perhaps of another compilation of the model, as the next one. */
static kt_exit store_pose(kmob_shots *s, const km_mechanism *mechanism, km_state *state) {
  km_error error;
  km_poses_compute(mechanism, state);
  return report(s, km_drawing_add_pose(s->drawing, mechanism, state, &error), &error);
}

/* One pose for every --at. */
static kt_exit copy_at(kmob_shots *s) {
  const kmob_draw_options *o = s->options;
  kt_exit result = KT_DONE;
  for (int i = 0; i < o->at.count && result == KT_DONE; ++i) {
    kt_texts sets = o->sets;
    kt_pose there = {.model = s->pose.model};
    if (sets.count == KT_MOST_TEXTS)
      return kt_usage(&o->common, "--set", sets.items[0], "fewer of them beside --at");
    sets.items[sets.count++] = o->at.items[i];
    result = kt_move_to_request(&o->common, o->path, &o->holds, &sets, &there);
    if (result == KT_DONE)
      result = store_pose(s, there.mechanism, there.state);
    there.model = NULL; /* it stays */
    kt_close(&there);
    km_text_format(&s->title, "%s%s", i ? ", " : o->at.count > 1 ? "Poses at " : "Pose at ", o->at.items[i]);
  }
  return result;
}

/* The motion of the model's analysis.sweep, on a state of its own. */
typedef struct motion {
  const kmob_shots *shots;
  km_sweep_plan plan;
  km_state *state;
  km_driver_motion *drive;
  km_arc_motion *follow;
} motion;

static km_status start_drive(motion *m, km_error *error) {
  const kmob_shots *s = m->shots;
  km_status status = km_sweep_enter_limits(s->pose.mechanism, m->state, &m->plan, error);
  return status ? status
                : km_driver_motion_create(s->pose.mechanism, m->state, m->plan.coordinate, m->plan.ignore_limits,
                                          &m->drive, error);
}

kt_exit kmob_shots_question(const kmob_shots *s, km_question **question, km_sweep_plan *plan) {
  const kmob_draw_options *o = s->options;
  km_error error;
  kt_exit result = kt_compute_question(&o->common, o->path, &o->asked, &s->pose, question);
  if (result != KT_DONE)
    return result;
  km_status status = km_question_make_plan(*question, plan, &error);
  if (status)
    kt_print_messages(&o->common, KM_ERROR, o->path, error.text);
  return kt_exit_of(status);
}

static kt_exit start(motion *m) {
  const kmob_shots *s = m->shots;
  km_error error;
  km_question *question = NULL;
  kt_exit planned = kmob_shots_question(s, &question, &m->plan);
  km_question_free(question);
  if (planned != KT_DONE)
    return planned;
  km_status status = km_state_create(s->pose.mechanism, &m->state, &error);
  if (!status)
    status = km_state_assign(s->pose.mechanism, m->state, s->pose.state, &error);
  if (!status && m->plan.arclength > 0.0)
    status = km_arc_motion_create(s->pose.mechanism, m->state, m->plan.direction, m->plan.sign, m->plan.ignore_limits,
                                  &m->follow, &error);
  else if (!status)
    status = start_drive(m, &error);
  return report(s, status, &error);
}

static void stop(motion *m) {
  km_driver_motion_free(m->drive);
  km_arc_motion_free(m->follow);
  km_state_free(m->state);
}

/* A full turn ends where it began: its last pose would hide the first. */
static bool full_turn(const motion *m) {
  const km_model *model = m->shots->pose.model;
  int c = m->plan.coordinate;
  if (m->follow || km_model_coordinate_is_length(model, c))
    return false;
  return fabs(fabs(m->plan.to - m->plan.from) * km_model_units(model).angle->si - 2.0 * M_PI) < 1e-6;
}

/* Moves to a part (0 … 1) of the range; false at its end within reach. */
static bool go(motion *m, double part) {
  if (m->follow) {
    double length = m->plan.arclength * m->plan.steps * part - km_arc_motion_length(m->follow);
    return length <= 0.0 || (!km_arc_motion_closed(m->follow) && km_arc_motion_advance(m->follow, length) == KM_OK);
  }
  return km_driver_motion_move_to(m->drive, m->plan.from + (m->plan.to - m->plan.from) * part).stop == KM_STOP_NONE;
}

/* Goes to FROM, or as near as it gets, where the range then begins. False if that is all there is.
 */
static bool move_to_start(motion *m) {
  if (m->follow || go(m, 0.0))
    return true;
  double bound = km_state_coordinate(m->state, m->plan.coordinate);
  bool forwards = m->plan.to >= m->plan.from;
  bool within = forwards ? bound > m->plan.from && bound < m->plan.to : bound < m->plan.from && bound > m->plan.to;
  m->plan.from = bound;
  return within;
}

typedef kt_exit (*visit)(void *context, const km_mechanism *mechanism, km_state *state);

/* Visits `count` poses from the beginning of the range; the last part of it is `last`. */
static kt_exit travel(motion *m, int count, double last, visit at, void *context) {
  double from = m->plan.from;
  bool whole = move_to_start(m);
  bool cut = !m->follow && (!whole || m->plan.from != from);
  kt_exit result = at(context, m->shots->pose.mechanism, m->state);
  for (int i = 1; i < count && whole && result == KT_DONE; ++i) {
    whole = go(m, last * i / (count - 1));
    result = at(context, m->shots->pose.mechanism, m->state);
  }
  bool closed = m->follow && km_arc_motion_closed(m->follow);
  if (result != KT_DONE || closed || (whole && !cut))
    return result;
  kt_print_message(&m->shots->options->common, KM_ERROR, "%s: a part of the range is out of reach",
                   m->shots->options->path);
  return KT_PARTIAL;
}

static kt_exit visit_pose(void *context, const km_mechanism *mechanism, km_state *state) {
  return store_pose(context, mechanism, state);
}

static void name_poses(kmob_shots *s, const motion *m) {
  const km_model *model = s->pose.model;
  if (m->follow)
    km_text_format(&s->title, "Poses along the motion");
  else
    km_text_format(&s->title, "Poses for %s from %g to %g %s", km_model_coordinate_label(model, m->plan.coordinate),
                   m->plan.from, m->plan.to, km_model_coordinate_unit(model, m->plan.coordinate));
}

static kt_exit copy_poses(kmob_shots *s) {
  motion m = {.shots = s};
  kt_exit result = start(&m);
  if (result == KT_DONE) {
    int n = s->asked;
    name_poses(s, &m);
    result = travel(&m, n, full_turn(&m) ? (n - 1.0) / n : 1.0, visit_pose, s);
  }
  stop(&m);
  return result;
}

static kt_exit visit_points(void *context, const km_mechanism *mechanism, km_state *state) {
  kmob_shots *s = context;
  km_error error;
  km_poses_compute(mechanism, state);
  return report(s, km_drawing_lead_paths(s->drawing, mechanism, state, &error), &error);
}

kt_exit kmob_shots_paths(kmob_shots *s) {
  const kt_texts *texts = &s->options->traces;
  kt_exit result = KT_DONE;
  for (int t = 0; t < texts->count && result == KT_DONE; ++t) {
    int frame;
    km_error error;
    result = kt_frame(&s->options->common, s->pose.model, "--trace", texts->items[t], &frame);
    if (result == KT_DONE)
      result = report(s, km_drawing_add_path(s->drawing, frame, texts->items[t], &error), &error);
  }
  return result;
}

static kt_exit copy_paths(kmob_shots *s) {
  motion m = {.shots = s};
  kt_exit result = kmob_shots_paths(s);
  if (result == KT_DONE)
    result = start(&m);
  if (result == KT_DONE)
    result = travel(&m, PATH_STEPS + 1, 1.0, visit_points, s);
  stop(&m);
  return result;
}

static kt_exit copy_file_pose(kmob_shots *s) {
  km_text_format(&s->title, s->options->sets.count ? "Pose at " : "Kinematic diagram");
  for (int i = 0; i < s->options->sets.count; ++i)
    km_text_format(&s->title, "%s%s", i ? ", " : "", s->options->sets.items[i]);
  return store_pose(s, s->pose.mechanism, s->pose.state);
}

kt_exit kmob_shots_compute(kmob_shots *s) {
  const kmob_draw_options *o = s->options;
  km_error error;
  kt_base_name(o->path, s->name, sizeof s->name);
  kt_exit result = kt_open(&o->common, o->path, &o->holds, &o->sets, &s->pose);
  if (result == KT_DONE)
    result = report(s, km_drawing_create(s->pose.mechanism, &s->drawing, &error), &error);
  if (result == KT_DONE && o->meshes)
    result = report(s, km_model_read_meshes(s->pose.model, &s->meshes, &error), &error);
  if (result != KT_DONE)
    return result;
  if (o->animate)
    return KT_DONE; /* the motion is all that is shown */
  result = o->at.count ? copy_at(s) : s->asked ? copy_poses(s) : copy_file_pose(s);
  if (o->traces.count && (result == KT_DONE || result == KT_PARTIAL)) {
    result = kt_worse(result, copy_paths(s));
  }
  return result == KT_DONE && s->title.failed ? out_of_memory(s) : result;
}

km_drawing_look kmob_shots_style(const kmob_shots *s) {
  km_drawing_look look = s->options->look;
  look.meshes = s->meshes;
  look.loads = !s->options->animate; /* arrows that turn would cover the motion */
  look.title = s->title.data;
  look.name = s->name;
  return look;
}

void kmob_shots_free(kmob_shots *s) {
  km_drawing_free(s->drawing);
  km_meshes_free(s->meshes);
  km_text_free(&s->title);
  kt_close(&s->pose);
}
