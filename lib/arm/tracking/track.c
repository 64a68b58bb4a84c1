/* Runs a method on a path and tabulates the track: joints, rates, path-control column, objectives, pose errors. */
#include "arm/tracking/track.h"

#include "arm/arm_arguments.h"
#include "arm/tracking/track_effort.h"
#include "base/clock.h"
#include "base/table.h"
#include "base/text.h"

#include <stdio.h>
#include <string.h>

static const km_method_function methods[KM_METHODS] = {km_method_greedy, km_method_lookahead, km_method_fixed,
                                                       km_method_dls,    km_method_gradient,  km_method_dp,
                                                       km_method_global};

/* Table under construction; is_ok is false after a failed allocation. */
typedef struct table_builder {
  km_table *table;
  bool is_ok;
} table_builder;

static void add_column(table_builder *m, const char *name, const char *unit) {
  m->is_ok = km_table_add_column(m->table, name, unit) >= 0 && m->is_ok;
}

/* Adds one column per joint. */
static void add_columns(table_builder *m, const km_arm *a, const char *prefix, const char *per) {
  const km_model *model = a->mechanism->model;
  for (int k = 0; k < a->n; ++k) {
    km_text name = {0}, unit = {0};
    km_text_format(&name, "%s.%s", prefix, km_arm_label(a, k));
    if (per)
      km_text_format(&unit, "%s%s", km_model_coordinate_unit(model, a->coordinate[k]), per);
    m->is_ok = m->is_ok && !name.failed && !unit.failed;
    add_column(m, name.data, per ? unit.data : NULL);
    km_text_free(&name);
    km_text_free(&unit);
  }
}

/* True if the table has a column of this objective: always for the first ones, else if it has a weight. */
static bool is_reported(const km_track *t, int kind) {
  return kind <= KM_LIMIT_DISTANCE || t->plan.objective.weight[kind] != 0.0;
}

/* Creates the table with its columns; NULL if out of memory. */
static km_table *create_table(const km_track *t) {
  const km_arm *a = t->arm;
  const char *length = a->mechanism->model->units.length->suffix;
  table_builder m = {km_table_create(), true};
  add_column(&m, "step", NULL);
  m.is_ok = km_table_add_plain_column(m.table, "s", length) >= 0 && m.is_ok;
  add_column(&m, "t", "s");
  add_columns(&m, a, "q", "");
  add_columns(&m, a, "v", "/s");
  add_columns(&m, a, "z", NULL);
  add_column(&m, "z.path", NULL);
  for (int k = 0; k < KM_OBJECTIVES; ++k) {
    char name[64];
    snprintf(name, sizeof name, "objective.%s", km_objective_word((km_objective_kind)k));
    if (is_reported(t, k))
      add_column(&m, name, NULL);
  }
  if (km_objective_single(&t->plan.objective) < 0)
    add_column(&m, "objective.weighted", NULL);
  add_column(&m, "error_position", length);
  add_column(&m, "error_rotation", a->mechanism->model->units.angle->suffix);
  add_column(&m, "limit_margin", NULL);
  m.is_ok = km_track_add_effort_columns(m.table, a) && m.is_ok;
  if (m.is_ok)
    return m.table;
  km_table_free(m.table);
  return NULL;
}

/* Joint rates v[n] of the track at row r, for which `space` was updated: those of the step that ends here, at the
 * start those of the step that begins here; 0 if the track has one row only. */
static void rates_at(const km_track *t, km_arm_space *space, const double *xi, const km_track_row *r,
                     const km_track_row *last, const km_track_row *next, double *v) {
  const km_arm *a = t->arm;
  const km_track_row *from = last ? last : r, *to = last ? r : next;
  double path[KM_ARM_MAX_JOINTS + 1], self[KM_ARM_MAX_JOINTS * KM_ARM_MAX_JOINTS], mean[KM_ARM_MAX_JOINTS];
  memset(v, 0, (size_t)a->n * sizeof *v);
  if (!to)
    return;
  for (int k = 0; k < a->n; ++k)
    mean[k] = (to->q[k] - from->q[k]) / (to->point.t - from->point.t);
  if (t->plan.method.kind == KM_FIXED)
    km_control_factor(a, space, xi, t->fixed);
  km_control_columns(a, space, NULL, path, self);
  km_path_node_rates(a, path, self, r->point.speed, mean, v);
}

/* Contribution of a row to the summary. */
typedef struct row_summary {
  double rate; /* largest joint rate, of joint `rate_column` */
  int rate_column;
  bool violates;
  double value, position, rotation, limit_margin;
  km_joint_effort effort;
} row_summary;

/* Adds a row to the summary of the track. Returns its weight in the mean of the objective: 1, or for objectives from
 * inverse dynamics the time of the step that ends there. */
static double count_row(km_track *t, const km_track_row *r, const km_track_row *last, const row_summary *of) {
  const km_arm *a = t->arm;
  km_track_summary *s = &t->summary;
  const double seconds = last ? r->point.t - last->point.t : 0.0;
  const double weight = km_objective_needs_forces(&t->plan.objective) ? seconds : 1.0;
  for (int k = 0; k < a->n && last; ++k)
    s->joint_travel += fabs(r->q[k] - last->q[k]);
  if (of->rate > s->rate) {
    s->rate = of->rate;
    s->rate_column = of->rate_column;
  }
  s->violations += of->violates;
  s->limit_margin = fmin(s->limit_margin, of->limit_margin);
  s->objective_min = fmin(s->objective_min, of->value);
  s->objective_mean += weight * of->value;
  s->error_position = fmax(s->error_position, of->position);
  s->error_rotation = fmax(s->error_rotation, of->rotation);
  return weight;
}

/* Checks limits and rates v[n] of a row. */
static void check_row(const km_arm *a, const double *q, const double *v, row_summary *of) {
  of->violates = km_arm_limit_passed(a, q) >= 0;
  of->limit_margin = km_arm_limit_distance(a, q);
  for (int k = 0; k < a->n; ++k) {
    if (fabs(v[k]) > of->rate) {
      of->rate = fabs(v[k]);
      of->rate_column = k;
    }
    of->violates = of->violates || fabs(v[k]) > a->rate[k] * (1.0 + 1e-9);
  }
}

/* Computes the cells of a row and its contribution to the summary. */
static void write_row(const km_track *t, km_arm_space *space, const km_track_row *r, const km_track_row *last,
                      const km_track_row *next, double *out, row_summary *of) {
  const km_arm *a = t->arm;
  double xi[KM_ARM_ROWS], path[KM_ARM_MAX_JOINTS + 1], self[KM_ARM_MAX_JOINTS * KM_ARM_MAX_JOINTS],
      values[KM_OBJECTIVES];
  double position, rotation, v[KM_ARM_MAX_JOINTS];
  km_arm_update(a, space, r->q);
  km_arm_task_rows(a, &space->pose.R, r->point.twist, xi);
  km_arm_error(a, space, &r->point.pose, NULL, &position, &rotation);
  km_control_factor(a, space, xi, NULL);
  km_control_columns(a, space, NULL, path, self);
  km_objective_values(a, space, r->q, path, r->point.speed, NULL, values);
  rates_at(t, space, xi, r, last, next, v);
  values[KM_RATE_MARGIN] = km_objective_rate_margin(a, v);
  if (a->mass.has_mass) {
    km_track_effort(t, space, r, last, next, &of->effort);
    km_joint_effort_values(&of->effort, values);
  }
  of->value = km_objective_sum(&t->plan.objective, values);
  of->position = position * a->length;
  of->rotation = rotation / a->mechanism->model->units.angle->si;
  check_row(a, r->q, v, of);
  *out++ = (double)r->sample;
  *out++ = r->point.s * a->length;
  *out++ = r->point.t;
  for (int k = 0; k < a->n; ++k)
    *out++ = km_arm_to_units(a, k, r->q[k]);
  for (int k = 0; k < a->n; ++k)
    *out++ = km_arm_to_units(a, k, v[k]);
  for (int k = 0; k <= a->n; ++k)
    *out++ = path[k];
  for (int k = 0; k < KM_OBJECTIVES; ++k)
    if (is_reported(t, k))
      *out++ = values[k];
  if (km_objective_single(&t->plan.objective) < 0)
    *out++ = of->value;
  *out++ = of->position;
  *out++ = of->rotation;
  *out++ = values[KM_LIMIT_DISTANCE];
  km_track_write_effort(a, &of->effort, out);
}

/* Row `index`: a sample that was reached, or the end of the track between two samples. */
static km_track_row row_of(const km_tracking_run *run, int index) {
  const km_path *path = run->plan->path;
  if (index < run->reached)
    return (km_track_row){run->q + (size_t)index * (size_t)run->arm->n, path->points[index], index};
  return (km_track_row){run->last, km_path_at(path, run->reached - 1, run->fraction), index};
}

/* Fewest rows for which another thread pays off. */
enum { ROWS_PAY = 16 };

/* Rows written in pieces by several threads. */
typedef struct writing {
  const km_track *track;
  const km_tracking_run *run;
  km_arm_space *spaces; /* [pieces] */
  double *cells;
  size_t width; /* cells of a row */
  row_summary *summaries;
  int count, pieces;
} writing;

/* Writes the rows of one piece. */
static void write_piece(void *context, int piece) {
  const writing *w = context;
  const long long count = w->count;
  int first = (int)(count * piece / w->pieces), end = (int)(count * (piece + 1) / w->pieces);
  for (int i = first; i < end; ++i) {
    km_track_row last = row_of(w->run, i > 0 ? i - 1 : i), here = row_of(w->run, i),
                 next = row_of(w->run, i + 1 < w->count ? i + 1 : i);
    write_row(w->track, &w->spaces[piece], &here, i > 0 ? &last : NULL, i + 1 < w->count ? &next : NULL,
              w->cells + (size_t)i * w->width, &w->summaries[i]);
  }
}

/* Writes all rows, in parallel if there are many. False: out of memory. */
static bool write_rows(km_track *t, km_tracking_run *run, int count, km_arena *arena, row_summary **summaries,
                       double **cells) {
  int most = t->plan.jobs < KM_MAX_THREADS ? t->plan.jobs : KM_MAX_THREADS;
  most = count / ROWS_PAY < most ? count / ROWS_PAY : most;
  writing w = {.track = t, .run = run, .count = count, .pieces = most > 1 ? most : 1};
  w.cells = *cells = count > 0 ? km_table_add_raw_rows(t->table, (size_t)count) : NULL;
  w.width = km_table_columns(t->table);
  w.summaries = *summaries = KM_ARENA_NEW(arena, row_summary, (size_t)count + 1);
  w.spaces = KM_ARENA_NEW(arena, km_arm_space, (size_t)w.pieces);
  bool is_ok = !arena->failed && (w.cells || count == 0);
  for (int i = 0; i < w.pieces && is_ok; ++i)
    is_ok = km_arm_space_create(t->arm, &w.spaces[i]);
  if (is_ok)
    km_team_run(w.pieces > 1 ? km_run_team(run) : NULL, w.pieces, write_piece, &w);
  for (int i = 0; i < w.pieces && w.spaces; ++i)
    km_arm_space_free(&w.spaces[i]);
  return is_ok;
}

/* Effector's origin at the end of the track, from its pose in the arm's frame. */
static void set_place(km_track *t, const km_pose *pose) {
  const km_arm *a = t->arm;
  km_vec3 p = km_vec3_add(a->origin, km_vec3_scale(a->length, pose->p));
  km_vec3_write(p, t->end.place);
}

/* Creates the table, writes its rows, and sums up the track. */
static km_status fill_table(km_track *t, km_tracking_run *run, km_error *error) {
  int count = run->reached + (run->stop && run->reached > 0 && run->fraction > 0.0);
  km_arena arena = {0};
  row_summary *summaries = NULL;
  double *cells = NULL, weights = 0.0;
  km_effort_sum sum = {.seconds = 0.0};
  km_track_row last = {0}, here = {0};
  memcpy(t->fixed, run->fixed, sizeof t->fixed);
  t->table = create_table(t);
  bool is_ok = t->table && write_rows(t, run, count, &arena, &summaries, &cells);
  for (int i = 0; i < count && is_ok; ++i) {
    last = here;
    here = row_of(run, i);
    weights += count_row(t, &here, i > 0 ? &last : NULL, &summaries[i]);
    cells += km_table_columns(t->table);
    km_track_add_effort(t, &summaries[i].effort, i > 0 ? here.point.t - last.point.t : 0.0, &sum, cells);
  }
  t->end = (km_track_end){.stop = run->stop,
                          .column = run->column,
                          .sample = run->reached - 1,
                          .s = here.point.s * t->arm->length,
                          .t = here.point.t,
                          .travel = here.point.travel * t->arm->length,
                          .turn = here.point.turn};
  set_place(t, count > 0 ? &here.point.pose : &t->plan.path->points[0].pose);
  if (is_ok && count > 0)
    t->summary.objective_mean = weights > 0.0 ? t->summary.objective_mean / weights : summaries[0].value;
  km_arena_free(&arena);
  return is_ok ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a track");
}

/* True if the start reaches the path's first pose to 1e-9 and is within the limits; sets the stop otherwise. */
static bool start_is_valid(km_track *t, km_tracking_run *run) {
  double position;
  km_arm_update(t->arm, &run->space.arm, run->start);
  double left = km_arm_error(t->arm, &run->space.arm, &t->plan.path->points[0].pose, NULL, &position, NULL);
  run->column = km_arm_limit_passed(t->arm, run->start);
  if (left <= 1e-9 && run->column < 0)
    return true;
  run->stop = KM_TRACK_START;
  run->reached = 0;
  return false;
}

static km_status check_plan(const km_arm *arm, const km_track_plan *plan, km_error *error) {
  km_status status = km_check_given(arm && plan, "arm or plan", error);
  if (!status)
    status = km_check_given(plan->path && plan->path->arm == arm, "path of this arm", error);
  if (!status)
    status = km_check_given(plan->start != NULL, "start", error);
  if (!status)
    status = km_check_objective(arm, &plan->objective, error);
  return status ? status : km_check_method(arm, &plan->method, error);
}

/* Runs a method on a path and tabulates the result. */
km_status km_track_run(const km_arm *arm, const km_track_plan *plan, km_track **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = check_plan(arm, plan, error);
  if (fits)
    return fits;
  km_tracking_run run;
  km_track *t = KM_NEW(km_track, 1);
  if (!t)
    return km_fail(error, KM_MEMORY, "out of memory for a track");
  t->arm = arm;
  t->plan = *plan;
  t->summary = (km_track_summary){.objective_min = (double)INFINITY,
                                  .limit_margin = 1.0,
                                  .effort = nan(""),
                                  .relative_effort = nan(""),
                                  .energy = nan(""),
                                  .positive_work = nan("")};
  if (!km_run_create(arm, &t->plan, &run)) {
    km_track_free(t);
    return km_fail(error, KM_MEMORY, "out of memory for a track");
  }
  double start = km_clock();
  km_status status = start_is_valid(t, &run) ? methods[plan->method.kind](&run, error) : KM_PARTIAL;
  t->summary.seconds = km_clock() - start;
  t->summary.evaluations = run.evaluations + run.space.arm.evaluations;
  t->summary.greedy_instead = run.greedy_instead;
  t->summary.converged = run.converged;
  t->summary.bounded = run.bounded;
  km_status filled = status == KM_OK || status == KM_PARTIAL ? fill_table(t, &run, error) : status;
  km_run_free(&run);
  if (filled) {
    km_track_free(t);
    return filled;
  }
  *out = t;
  return status;
}

void km_track_free(km_track *t) {
  if (!t)
    return;
  km_table_free(t->table);
  km_free(t);
}

km_track_end km_track_ending(const km_track *t) {
  if (!t)
    return (km_track_end){.stop = KM_TRACK_START, .column = -1, .sample = -1};
  return t->end;
}

int km_track_samples(const km_track *t) {
  return t ? t->plan.path->samples : 0;
}

const km_table *km_track_rows(const km_track *t) {
  if (!t)
    return NULL;
  return t->table;
}

km_track_summary km_track_summarise(const km_track *t) {
  if (!t)
    return (km_track_summary){.rate_column = -1};
  return t->summary;
}
