/* Path of a path study, bound to the arm: units, start pose, and the place of errors in the text. */
#include "arm/arm_arguments.h"
#include "arm/study/study_binding.h"
#include "model/units.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Poses with orientations from rotation vectors. */
static const km_frame_pose *poses_from_rotation_vectors(km_arena *arena, const km_path_segment *g, const double *turns,
                                                        double angle) {
  km_frame_pose *poses = KM_ARENA_NEW(arena, km_frame_pose, (size_t)g->point_count);
  for (int k = 0; k < g->point_count && poses; ++k) {
    const double *turn = &turns[3 * k];
    km_vec3 v = {turn[0] * angle, turn[1] * angle, turn[2] * angle};
    km_rotation R = km_quaternion_rotation(km_quaternion_exp(v));
    poses[k] = g->points[k];
    km_rotation_rows(&R, poses[k].R);
  }
  return poses;
}

/* Converts a plan to radians. */
static bool convert(km_arena *arena, const km_study_path *path, double angle, km_path_plan *out) {
  km_path_segment *segments = KM_ARENA_NEW(arena, km_path_segment, (size_t)path->plan.segment_count);
  *out = path->plan;
  out->segments = segments;
  out->turn_speed *= angle;
  for (int i = 0; i < out->segment_count && segments; ++i) {
    segments[i] = path->plan.segments[i];
    segments[i].angle *= angle;
  }
  if (segments && path->turns)
    segments[0].points = poses_from_rotation_vectors(arena, &segments[0], path->turns, angle);
  return !arena->failed;
}

/* First pose of the path, in the arm's units: the effector's pose at q, with position or orientation replaced by
 * stated ones. */
static bool find_first_pose(km_binder *b, const double *q, km_pose *out) {
  const km_arm *a = b->study->arm;
  const km_study_path *path = &b->def->path;
  km_arm_space space;
  if (!km_arm_space_create(a, &space))
    return km_binder_memory(b);
  km_arm_update(a, &space, q);
  *out = space.pose;
  km_arm_space_free(&space);
  km_pose given = km_arm_pose_of(a, &path->plan.start);
  if (path->start_p)
    out->p = given.p;
  if (path->start_R)
    out->R = given.R;
  return true;
}

/* Reports a fault with its place: the line of a file of poses, else the part of the segment. */
static void report_fault(km_binder *b, const km_path_fault *fault, const km_error *found) {
  const km_study_path *path = &b->def->path;
  char segment[KM_PATH_FAULT_TEXT], where[KM_ERROR_TEXT];
  km_study_place at = {where, path->place.option};
  if (path->file && fault->item >= 0)
    snprintf(where, sizeof where, "%s.csv: %s, line %d", path->place.text, path->file, path->lines[fault->item]);
  else if (path->file)
    snprintf(where, sizeof where, "%s.csv", path->place.text);
  else
    snprintf(where, sizeof where, "%s.%s", path->place.text, km_path_fault_text(fault, segment));
  km_binder_fault(b, &at, "%s", found->text);
}

/* Bound of the distance from the arm's origin to the effector: the sum of the links, over L; infinite for slides
 * without limits and for screws. */
static double reach_bound(const km_arm *a) {
  double reach = km_vec3_norm(a->tool.p);
  for (int k = 0; k < a->n; ++k) {
    const km_arm_motion *m = &a->motions[k];
    reach += km_vec3_norm(m->before.p);
    if (m->primitive != KM_REVOLUTE)
      reach += m->primitive == KM_PRISMATIC ? fmax(fabs(a->low[k]), fabs(a->high[k])) : HUGE_VAL;
  }
  return reach;
}

/* Unit of length in which a path of this size fits the arm: not larger than the reach, nor below a twentieth of it;
 * NULL: none but the model's. */
static const km_unit *fitting_unit(const km_unit *own, double size, double reach) {
  for (const km_unit *u = km_quantity_units(KM_LENGTH); u->word; ++u) {
    double scaled = size * u->si / own->si;
    if (u->si != own->si && scaled <= reach && scaled >= 0.05 * reach)
      return u;
  }
  return NULL;
}

/* Notes a path whose lengths don't fit the arm: ten times its reach, or a hundredth of it. */
static void note_units(km_binder *b) {
  static const double most = 10.0, least = 0.01;
  const km_arm *a = b->study->arm;
  const km_path *path = b->study->path;
  const km_unit *own = a->mechanism->model->units.length;
  double reach = reach_bound(a), size = 0.0;
  for (int i = 0; i < path->samples; ++i)
    size = fmax(size, km_vec3_norm(path->points[i].pose.p));
  if (!isfinite(reach) || (size <= most * reach && size >= least * reach))
    return;
  const km_unit *unit = fitting_unit(own, size, reach);
  km_text text = {0};
  km_text_format(&text, "the path goes up to %.3g %s from the arm's first joint, but the arm's reach is %.3g %s",
                 size * a->length, own->suffix, reach * a->length, own->suffix);
  if (unit)
    km_text_format(&text, ": its lengths look like %s; write them in %s, times %.6g", unit->word, own->word,
                   unit->si / own->si);
  km_messages_add(b->messages, KM_WARNING, "%s: %s", b->def->path.place.text, text.data ? text.data : "");
  km_text_free(&text);
}

bool km_bind_path(km_binder *b, const double *q) {
  const km_study_path *path = &b->def->path;
  km_path_fault fault = KM_PATH_NO_FAULT;
  km_path_plan plan;
  km_pose start;
  km_error error;
  if (!path->plan.segments)
    return b->def->path_optional || km_binder_fault(b, &path->place, "found none; expected the path to follow");
  if (!km_binder_pass(b, &path->place, km_check_pose(&path->plan.start, &error), &error))
    return false;
  if (!find_first_pose(b, q, &start))
    return false;
  km_status status = km_path_plan_check(&path->plan, &fault, &error);
  if (!status && !convert(&b->study->arena, path, b->mechanism->model->units.angle->si, &plan))
    return km_binder_memory(b);
  if (!status)
    status = km_path_build(b->study->arm, &plan, &start, &b->study->path, &fault, &error);
  if (status == KM_MEMORY)
    return km_binder_pass(b, &path->place, status, &error);
  if (status)
    report_fault(b, &fault, &error);
  else
    note_units(b);
  return !status;
}
