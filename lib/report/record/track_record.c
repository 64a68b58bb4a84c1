/* Tracks of arms and their ends as a record and as text. */
#include "report/record/track_record.h"

#include "arm/tracking/joint_course.h"
#include "arm/tracking/singular_joints.h"
#include "report/record/record.h"

#include <stdio.h>
#include <string.h>

bool km_tracks_are_whole(const km_tracks *t) {
  if (!t || !t->study || !t->study->path || !t->name || !t->model || t->count < 0 || (t->count > 0 && !t->items) ||
      t->count > t->study->method_count)
    return false;
  for (int i = 0; i < t->count; ++i)
    if (t->items[i] && t->items[i]->arm != t->study->arm)
      return false;
  return true;
}

void km_tracks_label(const km_tracks *t, int index, char separator, char *out, size_t size) {
  if (!out || !size)
    return;
  out[0] = '\0';
  if (!t || !t->study || index < 0 || index >= t->study->method_count)
    return;
  const char *word = t->study->methods[index].word;
  int before = 0;
  for (int i = 0; i < index; ++i)
    before += strcmp(t->study->methods[i].word, word) == 0;
  if (before)
    snprintf(out, size, "%s%c%d", word, separator, before + 1);
  else
    snprintf(out, size, "%s", word);
}

/* +1: one track ends further along the path than the other, -1: the other way round; 0: where a limit ends both, it
 * is found to rounding. */
static int goes_further(const km_track *one, const km_track *other) {
  double way = one->end.s - other->end.s, same = 1e-6 * fmax(one->end.s, other->end.s);
  return way > same ? 1 : way < -same ? -1 : 0;
}

/* 1: x is larger by more than 1e-9 of both, -1: smaller, 0: neither. NaN is smaller than any number. */
static int compare(double x, double y) {
  if (isnan(x) || isnan(y))
    return isnan(y) - isnan(x);
  double difference = x - y;
  return fabs(difference) <= 1e-9 * fmax(fabs(x), fabs(y)) ? 0 : difference > 0.0 ? 1 : -1;
}

/* Further along the path, then by the objective's own aggregate, then by the other one, by less travel of the joints
 * and by a lower rate. */
static bool is_better(const km_track *a, const km_track *b) {
  const km_track_summary *x = &a->summary, *y = &b->summary;
  int least = compare(x->objective_min, y->objective_min), mean = compare(x->objective_mean, y->objective_mean);
  bool by_mean = km_objective_by_mean(&a->plan.objective);
  const int order[] = {goes_further(a, b), by_mean ? mean : least, by_mean ? least : mean,
                       compare(y->joint_travel, x->joint_travel), compare(y->rate, x->rate)};
  for (size_t i = 0; i < sizeof order / sizeof *order; ++i)
    if (order[i])
      return order[i] > 0;
  return false;
}

int km_tracks_best(const km_tracks *t) {
  int best = -1;
  if (!t || !t->items)
    return -1;
  for (int i = 0; i < t->count; ++i)
    if (t->items[i] && (best < 0 || is_better(t->items[i], t->items[best])))
      best = i;
  return best;
}

static const char *length_unit(const km_arm *a) {
  return a->mechanism->model->units.length->suffix;
}

static const char *angle_unit(const km_arm *a) {
  return a->mechanism->model->units.angle->suffix;
}

/* Radians in the model's angle unit. */
static double angle_shown(const km_arm *a, double angle) {
  return angle / a->mechanism->model->units.angle->si;
}

static void add_held(const km_track *t, km_text *out) {
  int count = 0;
  for (int k = 0; k < t->arm->n; ++k)
    if (t->fixed[k])
      km_text_format(out, "%s %s", count++ ? "," : "with joint", km_arm_label(t->arm, k));
  km_text_add(out, " held the arm can't follow the path any further; with all its joints it could");
}

/* Coordinate k of the last row, in the model's unit. */
static double last_value(const km_track *t, int k) {
  const double *last = km_table_row(t->table, km_table_rows(t->table) - 1);
  return last[km_table_span(t->table, "q.").first + (size_t)k];
}

/* Limit of coordinate k that its last value is nearer to, in the model's unit; infinite: it has none. */
static double nearest_limit(const km_track *t, int k) {
  const km_arm *a = t->arm;
  double q = last_value(t, k), low = km_arm_to_units(a, k, a->low[k]), high = km_arm_to_units(a, k, a->high[k]);
  return fabs(q - low) < fabs(q - high) ? low : high;
}

/* Appends the joint with the smallest part of its range left. */
static void add_nearest_limit(const km_track *t, km_text *out) {
  const km_arm *a = t->arm;
  int nearest = -1;
  double least = HUGE_VAL;
  for (int k = 0; k < a->n; ++k) {
    double range = km_arm_to_units(a, k, a->high[k]) - km_arm_to_units(a, k, a->low[k]);
    double part = fabs(last_value(t, k) - nearest_limit(t, k)) / range;
    if (isfinite(range) && part < least) {
      least = part;
      nearest = k;
    }
  }
  if (nearest >= 0)
    km_text_format(out, "; joint %s is nearest to a limit, %.3g from %.6g %s", km_arm_label(a, nearest),
                   fabs(last_value(t, nearest) - nearest_limit(t, nearest)), nearest_limit(t, nearest),
                   km_model_coordinate_unit(a->mechanism->model, a->coordinate[nearest]));
}

/* Appends the joints that make the last configuration singular, and of a start one with them moved. False: none are
 * known. */
static bool add_way_out(const km_track *t, km_text *out) {
  const km_arm *a = t->arm;
  double q[KM_ARM_MAX_JOINTS];
  km_singular_joints found;
  if (!km_table_rows(t->table))
    return false;
  for (int k = 0; k < a->n; ++k)
    q[k] = km_arm_from_units(a, k, last_value(t, k));
  if (!km_singular_joints_find(a, q, &found) || !found.count)
    return false;
  for (int i = 0; i < found.count; ++i)
    km_text_format(out, "%s %s at %.4g %s",
                   i == 0                ? ";"
                   : i + 1 < found.count ? ","
                                         : " and",
                   km_arm_label(a, found.joint[i]), last_value(t, found.joint[i]),
                   km_model_coordinate_unit(a->mechanism->model, a->coordinate[found.joint[i]]));
  km_text_format(out, " make%s it singular", found.count == 1 ? "s" : "");
  for (int k = 0; k < a->n && t->end.sample <= 0; ++k) {
    const double value = km_arm_to_units(a, k, found.q[k]);
    km_text_format(out, "%s%.4g", k ? "," : "; start elsewhere, such as --q ", fabs(value) < 1e-6 ? 0.0 : value);
  }
  return true;
}

void km_track_end_text(const km_track *t, km_text *out) {
  if (!t || !out)
    return;
  const km_arm *a = t->arm;
  const km_track_end *end = &t->end;
  if (end->stop == KM_TRACK_COMPLETE)
    return;
  const char *label = end->column >= 0 ? km_arm_label(a, end->column) : "";
  bool is_explained = end->stop == KM_TRACK_LIMIT || end->stop == KM_TRACK_RATE || end->stop == KM_TRACK_START;
  km_text_format(
      out, "stops after %.9g %s and %.9g %s (s = %.9g %s, t = %.9g s, sample %d of %d) at (%.6g, %.6g, %.6g) %s: ",
      end->travel, length_unit(a), angle_shown(a, end->turn), angle_unit(a), end->s, length_unit(a), end->t,
      end->sample < 0 ? 0 : end->sample, t->plan.path->samples - 1, end->place[0], end->place[1], end->place[2],
      length_unit(a));
  switch (end->stop) {
  case KM_TRACK_LIMIT:
    km_text_format(out, "joint %s is at its limit, %.9g %s", label, nearest_limit(t, end->column),
                   km_model_coordinate_unit(a->mechanism->model, a->coordinate[end->column]));
    break;
  case KM_TRACK_RATE:
    km_text_format(out, "joint %s would have to move faster than its %.9g %s/s", label,
                   km_arm_to_units(a, end->column, a->rate[end->column]),
                   km_model_coordinate_unit(a->mechanism->model, a->coordinate[end->column]));
    break;
  case KM_TRACK_SINGULAR:
    km_text_add(out,
                "singular pose: the arm can't go on along the path from here, though the poses ahead are in reach");
    is_explained = add_way_out(t, out);
    break;
  case KM_TRACK_FIXED_JOINTS:
    add_held(t, out);
    break;
  case KM_TRACK_NOT_CONVERGED:
    km_text_add(out, "dynamic programming stops: beyond here it takes more steps than it makes");
    break;
  case KM_TRACK_WORKSPACE_BOUNDARY:
    km_text_add(out, "workspace edge: no pose of the arm reaches what follows");
    break;
  default:
    km_text_add(out,
                "there is no pose to start from: the path's first pose is out of reach, or never within the limits");
  }
  if (!is_explained && km_table_rows(t->table) > 0)
    add_nearest_limit(t, out);
}

static void add_settings(const km_method *m, const km_track *t, km_value *record, km_arena *arena) {
  const double degrees = 180.0 / M_PI;
  switch (m->kind) {
  case KM_LOOKAHEAD: {
    int samples = t->plan.path->samples, stride = m->stride > 0 ? m->stride : samples / 12 > 1 ? samples / 12 : 1;
    km_value_number(arena, record, "branches", m->branches);
    km_value_number(arena, record, "levels", m->levels);
    km_value_number(arena, record, "angle", round(m->angle * degrees * 1e9) / 1e9);
    km_value_number(arena, record, "stride", stride);
    km_value_string(arena, record, "value", m->sum || km_objective_needs_forces(&t->plan.objective) ? "sum" : "min");
    km_value_boolean(arena, record, "greedy_instead", t->summary.greedy_instead);
    break;
  }
  case KM_DLS:
    km_value_number(arena, record, "damping", m->damping);
    km_value_number(arena, record, "below", m->below);
    break;
  case KM_GRADIENT:
    km_value_number(arena, record, "gain", m->gain);
    break;
  case KM_DP:
    km_value_number(arena, record, "spacing", m->spacing);
    km_value_number(arena, record, "converged_to", t->summary.converged);
    km_value_boolean(arena, record, "bounded", t->summary.bounded);
    break;
  case KM_GLOBAL:
    km_value_number(arena, record, "knots", m->knots);
    km_value_number(arena, record, "evaluations", m->evaluations);
    break;
  default:
    break;
  }
}

static void add_summary(const km_track *t, km_value *record, km_arena *arena) {
  const km_track_summary *s = &t->summary;
  size_t rows = km_table_rows(t->table);
  km_value *out = km_value_add(arena, record, "summary", KM_OBJECT);
  km_value_number(arena, out, "error_position", s->error_position);
  km_value_number(arena, out, "error_rotation", s->error_rotation);
  km_value_number(arena, out, "objective_min", s->objective_min);
  km_value_number(arena, out, "objective_mean", s->objective_mean);
  km_value_number(arena, out, "joint_travel", s->joint_travel);
  km_value_number(arena, out, "max_rate", s->rate);
  km_value_string(arena, out, "max_rate_joint", rows ? km_arm_label(t->arm, s->rate_column) : "");
  km_value_number(arena, out, "limit_margin", s->limit_margin);
  km_value_number(arena, out, "violations", s->violations);
  km_value_number(arena, out, "evaluations", (double)s->evaluations);
  if (!t->arm->mass.has_mass)
    return;
  km_value_number(arena, out, "effort", s->effort);
  if (km_table_find(t->table, "relative_effort") >= 0)
    km_value_number(arena, out, "relative_effort", s->relative_effort);
  km_value_number(arena, out, "energy", s->energy);
  km_value_number(arena, out, "positive_work", s->positive_work);
}

static void add_track(const km_tracks *all, int index, km_value *list, km_arena *arena) {
  const km_track *t = all->items[index];
  char label[64];
  km_value *record = km_value_add(arena, list, NULL, KM_OBJECT);
  km_tracks_label(all, index, '-', label, sizeof label);
  km_value_string(arena, record, "method", t->plan.method.word);
  km_value_string(arena, record, "label", label);
  add_settings(&t->plan.method, t, record, arena);
  add_summary(t, record, arena);
  km_table_record(t->table, record, arena);
  km_text why = {0};
  km_track_end_text(t, &why);
  km_value_boolean(arena, record, "complete", t->end.stop == KM_TRACK_COMPLETE);
  if (why.size)
    km_value_string(arena, record, "stopped_by", why.data);
  else
    km_value_add(arena, record, "stopped_by", KM_NULL);
  km_text_free(&why);
}

km_value *km_arm_record(const km_arm *a, const char *model, km_arena *arena) {
  static const char *const tasks[] = {"pose", "position", "axis"};
  const km_model_frame *frame = &a->mechanism->model->frames[a->frame];
  km_value *record = km_record_head(a->mechanism, "kredund", model, arena);
  km_value *effector = km_value_add(arena, record, "effector", KM_LIST);
  km_value_string(arena, effector, NULL, a->mechanism->model->bodies[frame->body].name);
  km_value_string(arena, effector, NULL, frame->name);
  km_value_string(arena, record, "task", tasks[a->task]);
  km_value_number(arena, record, "scale", a->length);
  km_value *joints = km_value_add(arena, record, "joints", KM_LIST);
  for (int k = 0; k < a->n; ++k)
    km_value_string(arena, joints, NULL, km_arm_label(a, k));
  return record;
}

km_value *km_tracks_record(const km_tracks *t, const char *model, km_arena *arena) {
  if (!km_tracks_are_whole(t) || !model || !arena)
    return NULL;
  const km_path *path = t->study->path;
  km_value *record = km_arm_record(t->study->arm, model, arena);
  km_value_string(arena, record, "objective", km_objective_name(&t->study->objective));
  km_value *about = km_value_add(arena, record, "path", KM_OBJECT);
  km_value_number(arena, about, "samples", path->samples);
  km_value_number(arena, about, "length", km_path_travel(path, path->samples - 1));
  km_value_number(arena, about, "turn", angle_shown(path->arm, km_path_turn(path, path->samples - 1)));
  km_value_number(arena, about, "s", km_path_length(path, path->samples - 1));
  km_value_number(arena, about, "seconds", km_path_time(path, path->samples - 1));
  km_value *list = km_value_add(arena, record, "tracks", KM_LIST);
  for (int i = 0; i < t->count && !arena->failed; ++i)
    if (t->items[i])
      add_track(t, i, list, arena);
  return arena->failed ? NULL : record;
}

static void print_head(const km_tracks *t, km_text *out) {
  const km_arm *a = t->study->arm;
  const km_path *path = t->study->path;
  km_text_format(out,
                 "%s: %d samples over %.6g %s and %.6g %s in %.6g s; %d joints, %d to spare; lengths over L = "
                 "%.6g %s (%s)\n",
                 t->name, path->samples, km_path_travel(path, path->samples - 1), length_unit(a),
                 angle_shown(a, km_path_turn(path, path->samples - 1)), angle_unit(a),
                 km_path_time(path, path->samples - 1), a->n, a->freedom, a->length, length_unit(a),
                 km_length_source_name(a->mechanism->length_source));
}

static void print_line(const km_tracks *all, int index, km_text *out) {
  const km_track *t = all->items[index];
  const km_track_summary *s = &t->summary;
  char label[64];
  km_tracks_label(all, index, ' ', label, sizeof label);
  size_t rows = km_table_rows(t->table);
  if (!rows) {
    km_text_format(out, "  %-12s nothing was reached\n", label);
    return;
  }
  double part = 100.0 * t->end.s / km_path_length(t->plan.path, t->plan.path->samples - 1);
  km_text_format(out, "  %-12s %6.1f%%  %9.3g %8.2g  %9.4g %9.4g  %8.4g %8.4g  %9.4g %10d  %11lu\n", label, part,
                 s->error_position, s->error_rotation, s->objective_min, s->objective_mean, s->joint_travel, s->rate,
                 s->limit_margin, s->violations, s->evaluations);
}

/* Effort and energy of the tracks, of an arm with masses. */
static void print_efforts(const km_tracks *all, km_text *out) {
  const km_arm *a = all->study->arm;
  const char *force = a->mechanism->model->units.force->suffix;
  if (!a->mass.has_mass)
    return;
  km_text_format(out, "  %-12s %19s %12s %14s\n", "", "effort (mean)", "energy", "positive work");
  km_text_format(out, "  %-12s %11s^2*%s^2 %*s*%s %*s*%s\n", "", force, length_unit(a),
                 11 - (int)strlen(length_unit(a)), force, length_unit(a), 13 - (int)strlen(length_unit(a)), force,
                 length_unit(a));
  for (int i = 0; i < all->count; ++i) {
    const km_track *t = all->items[i];
    char label[64];
    if (!t || km_table_rows(t->table) < 2)
      continue;
    km_tracks_label(all, i, ' ', label, sizeof label);
    km_text_format(out, "  %-12s %19.6g %12.6g %14.6g\n", label, t->summary.effort, t->summary.energy,
                   t->summary.positive_work);
  }
}

/* Text about the accuracy of the reference. */
static void print_remarks(const km_tracks *all, int index, km_text *out) {
  const km_track *track = all->items[index];
  double change = track->summary.converged;
  char label[64];
  km_tracks_label(all, index, ' ', label, sizeof label);
  if (isfinite(change))
    km_text_format(out, "  %s: %s change the value by %.2g%%%s\n", label,
                   km_objective_needs_forces(&track->plan.objective) ? "a quarter of the spacing and half the stage"
                                                                     : "half the spacing and stage",
                   100.0 * change, change < 0.02 ? "" : ": no reference yet");
  else if (track->plan.method.kind == KM_DP && track->end.stop != KM_TRACK_START)
    km_text_format(out, "  %s: %s\n", label,
                   track->end.stop          ? "stops short: no reference"
                   : track->summary.bounded ? "more states or tilts than it keeps, so they lie wider: no reference yet"
                                            : "stops short at one of two spacings: no reference yet");
}

/* The best of several tracks, with the reason. */
static void print_best(const km_tracks *t, km_text *out) {
  int best = km_tracks_best(t);
  const km_track *track = best >= 0 ? t->items[best] : NULL;
  if (!track || !km_table_rows(track->table))
    return;
  const km_objective *objective = &track->plan.objective;
  bool mean = km_objective_by_mean(objective);
  char label[64];
  km_tracks_label(t, best, ' ', label, sizeof label);
  km_text_format(out, "  best: %s, which %s with %s %.4g %s\n", label,
                 track->end.stop ? "gets furthest" : "reaches the end", km_objective_name(objective),
                 mean ? track->summary.objective_mean : track->summary.objective_min, mean ? "on average" : "at least");
}

void km_track_limits_words(const km_track *t, km_text *out) {
  const km_arm *a = t->arm;
  const int limiting = km_limiting_joint(t), fastest = km_fastest_joint(t);
  if (limiting >= 0) {
    const km_joint_course course = km_joint_course_find(t, limiting);
    km_text_format(out, "%s comes nearest to a limit: %.3g %% of half its range are left at s = %.4g %s",
                   km_arm_label(a, limiting), fabs(100.0 * course.margin) < 1e-6 ? 0.0 : 100.0 * course.margin,
                   course.margin_s, length_unit(a));
  }
  if (fastest >= 0)
    km_text_format(out, "%s%s is the fastest of its drive: %.3g %% of its largest rate", limiting >= 0 ? "; " : "",
                   km_arm_label(a, fastest), 100.0 * km_joint_course_find(t, fastest).rate_part);
}

/* The joints that limit the best track. */
static void print_limits(const km_tracks *t, km_text *out) {
  const int best = km_tracks_best(t);
  km_text words = {0};
  if (best < 0 || !t->items[best] || !km_table_rows(t->items[best]->table))
    return;
  km_track_limits_words(t->items[best], &words);
  if (words.size)
    km_text_format(out, "  %s\n", words.data);
  out->failed = out->failed || words.failed;
  km_text_free(&words);
}

void km_tracks_print(const km_tracks *t, km_text *out) {
  if (!km_tracks_are_whole(t) || !out)
    return;
  print_head(t, out);
  if (t->count > 1)
    print_best(t, out);
  print_limits(t, out);
  const char *name = km_objective_name(&t->study->objective);
  km_text_format(out, "  %-12s %7s  %9s %8s  %19s  %8s %8s  %9s\n", "", "", "position", "rotation", name, "joint",
                 "largest", "limit");
  km_text_format(out, "  %-12s %7s  %9s %8s  %9s %9s  %8s %8s  %9s %10s  %11s\n", "method", "reached", "error", "error",
                 "min", "mean", "travel", "rate", "margin", "violations", "evaluations");
  km_text_format(out, "  %-12s %7s  %9s %8s  %9s %9s  %8s %8s\n", "", "", length_unit(t->study->arm),
                 angle_unit(t->study->arm), "", "", "rad", "rad/s");
  for (int i = 0; i < t->count; ++i)
    if (t->items[i])
      print_line(t, i, out);
  print_efforts(t, out);
  for (int i = 0; i < t->count; ++i)
    if (t->items[i])
      print_remarks(t, i, out);
}
