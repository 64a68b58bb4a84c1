/* Columns and sums of a track from inverse dynamics (docs/theory.md 12.10).
 *
 *   effort = 1/T ∫ Σ τ² dt,   energy = ∫ Σ |τ q̇| dt,   positive work = ∫ Σ max(τ q̇, 0) dt      sums over the steps */
#include "arm/tracking/track_effort.h"

#include "arm/arm_dynamics.h"
#include "base/table.h"

#include <stdio.h>

/* True if every drive of the arm states its largest force. */
static bool has_force_limits(const km_arm *a) {
  for (int k = 0; k < a->n; ++k)
    if (!(a->mass.force_limit[k] < (double)INFINITY))
      return false;
  return true;
}

bool km_track_add_effort_columns(km_table *table, const km_arm *a) {
  const char *force = a->mechanism->model->units.force->suffix, *length = a->mechanism->model->units.length->suffix;
  char torque[32], square[64], power[64];
  if (!a->mass.has_mass)
    return true;
  snprintf(torque, sizeof torque, "%s*%s", force, length);
  snprintf(square, sizeof square, "%s^2*%s^2", force, length);
  snprintf(power, sizeof power, "%s/s", torque);
  bool is_ok = true;
  for (int k = 0; k < a->n; ++k)
    is_ok = km_table_add_joined_column(table, "f.", km_arm_label(a, k), "",
                                       a->motions[k].primitive == KM_PRISMATIC ? force : torque) &&
            is_ok;
  is_ok = km_table_add_column(table, "effort", square) >= 0 && is_ok;
  if (has_force_limits(a))
    is_ok = km_table_add_column(table, "relative_effort", NULL) >= 0 && is_ok;
  is_ok = km_table_add_column(table, "power", power) >= 0 && is_ok;
  is_ok = km_table_add_column(table, "energy", torque) >= 0 && is_ok;
  return km_table_add_column(table, "positive_work", torque) >= 0 && is_ok;
}

/* Path-control and pose-control columns of a row. */
typedef struct row_columns {
  double path[KM_ARM_MAX_JOINTS + 1], self[KM_ARM_MAX_JOINTS * KM_ARM_MAX_JOINTS];
} row_columns;

/* Columns of the track's steps at a row: without the fixed joints, if the method fixes joints. */
static km_step_side side_of(const km_track *t, km_arm_space *space, const km_track_row *r, row_columns *columns) {
  double xi[KM_ARM_ROWS];
  km_arm_update(t->arm, space, r->q);
  km_arm_task_rows(t->arm, &space->pose.R, r->point.twist, xi);
  km_control_factor(t->arm, space, xi, t->plan.method.kind == KM_FIXED ? t->fixed : NULL);
  km_control_columns(t->arm, space, NULL, columns->path, columns->self);
  return (km_step_side){r->q, columns->path, columns->self, r->point.speed};
}

void km_track_effort(const km_track *t, km_arm_space *space, const km_track_row *r, const km_track_row *last,
                     const km_track_row *next, km_joint_effort *out) {
  const km_path *path = t->plan.path;
  const km_track_row *from = last ? last : r, *to = last ? r : next;
  row_columns columns[2];
  const km_step_side start = side_of(t, space, from, &columns[0]);
  if (!to) {
    km_joint_effort_at_rest(t->arm, from->q, start.path, start.speed, out);
    return;
  }
  const km_step_side end = side_of(t, space, to, &columns[1]);
  const bool corner = to->point.t == path->points[to->sample].t && km_path_has_corner(path, to->sample);
  km_joint_effort_of_step(t->arm, &start, &end, to->point.t - from->point.t, corner, out);
}

void km_track_write_effort(const km_arm *a, const km_joint_effort *effort, double *out) {
  if (!a->mass.has_mass)
    return;
  for (int k = 0; k < a->n; ++k)
    *out++ = km_arm_force_to_units(a, k, effort->force[k]);
  *out++ = effort->effort;
  if (has_force_limits(a))
    *out++ = effort->relative;
  *out = effort->power;
}

void km_track_add_effort(km_track *t, const km_joint_effort *effort, double seconds, km_effort_sum *sum,
                         double *row_end) {
  km_track_summary *s = &t->summary;
  if (!t->arm->mass.has_mass)
    return;
  if (seconds > 0.0) {
    sum->seconds += seconds;
    sum->effort += seconds * effort->effort;
    sum->relative += seconds * effort->relative;
    sum->energy += seconds * effort->power;
    sum->positive += seconds * effort->positive_power;
    s->effort = sum->effort / sum->seconds;
    s->relative_effort = sum->relative / sum->seconds;
    s->energy = sum->energy;
    s->positive_work = sum->positive;
  }
  row_end[-2] = sum->energy;
  row_end[-1] = sum->positive;
}
