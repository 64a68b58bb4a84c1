/* Rates that keep the closed loops. */
#include "dynamics/dynamics.h"

#include "base/check.h"
#include "kinematics/closure.h"

/* The prescribed coordinates' part of the rates: with the others' independent rates 0. */
static void prescribed_part(const km_dynamics *d, const km_state *s, int index, double *x, double *direction) {
  const km_mechanism *m = d->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  for (int k = 0; k < sub->columns; ++k)
    x[k] = 0.0;
  for (int k = p->rank; k < p->columns; ++k) {
    int c = coordinate[p->column[k]];
    if (!d->driven[c])
      continue;
    km_partition_direction(p, p->column[k], direction);
    for (int i = 0; i < sub->columns; ++i)
      x[i] += s->rate[c] / m->unit[c] * direction[i];
  }
}

/* D⁻¹ Z Zᵀ D of the rest, Z over the independent coordinates that aren't prescribed. */
static bool keep_null_part(const km_dynamics *d, km_state *s, int index, const double *y, double *sum) {
  const km_mechanism *m = d->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const km_partition *p = &s->partition[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  const double *weight = m->column_weight + sub->column_start;
  int count = km_partition_freedom(p);
  for (int k = p->rank; k < p->columns; ++k)
    count -= d->driven[coordinate[p->column[k]]];
  const double *Z = km_state_null(m, s, index, count);
  if (!Z && count > 0)
    return false;
  for (int k = 0; k < sub->columns; ++k)
    sum[k] = 0.0;
  for (int v = 0; v < count; ++v) {
    const double *z = Z + (size_t)v * (size_t)sub->columns;
    double dot = 0.0;
    for (int k = 0; k < sub->columns; ++k)
      dot += z[k] * weight[k] * y[k];
    for (int k = 0; k < sub->columns; ++k)
      sum[k] += dot * z[k] / weight[k];
  }
  return true;
}

static bool project(km_dynamics *d, km_state *s, int index, double *changed, double *size) {
  const km_mechanism *m = d->mechanism;
  const km_substructure *sub = &m->substructures[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  double *x = d->step, *y = s->work, *kept = s->part;
  prescribed_part(d, s, index, x, y);
  for (int k = 0; k < sub->columns; ++k)
    y[k] = s->rate[coordinate[k]] / m->unit[coordinate[k]] - x[k];
  if (!keep_null_part(d, s, index, y, kept))
    return false;
  for (int k = 0; k < sub->columns; ++k) {
    int c = coordinate[k];
    double rate = m->unit[c] * (x[k] + kept[k]), change = m->scale[c] * (rate - s->rate[c]);
    *changed += change * change;
    *size += m->scale[c] * m->scale[c] * s->rate[c] * s->rate[c];
    s->rate[c] = rate;
  }
  return true;
}

km_status km_dynamics_project_rates(km_dynamics *d, km_state *s, double *change, km_error *error) {
  km_status status = km_check_given(d != NULL, "equations of motion", error);
  if (!status)
    status = km_check_state(d->mechanism, s, error);
  if (status)
    return status;
  double changed = 0.0, size = 0.0;
  status = km_dynamics_bring(d, s, error);
  if (status)
    return status;
  km_dynamics_drive(d, s, true);
  double *kept = KM_NEW(double, (size_t)s->mechanism->coordinate_count);
  if (!kept)
    return km_fail(error, KM_MEMORY, "out of memory for the rates");
  for (int c = 0; c < s->mechanism->coordinate_count; ++c)
    kept[c] = s->rate[c];
  bool closed = km_constraints_update(d, s, true); /* pivots; its rates aren't the nearest ones */
  for (int c = 0; c < s->mechanism->coordinate_count; ++c)
    s->rate[c] = kept[c];
  km_free(kept);
  bool memory = true;
  for (int i = 0; closed && memory && i < d->mechanism->topology.substructure_count; ++i)
    memory = project(d, s, i, &changed, &size);
  if (!memory)
    return km_fail(error, KM_MEMORY, "out of memory for the rates");
  if (change)
    *change = size > 0.0 ? sqrt(changed / size) : sqrt(changed);
  return closed ? KM_OK : km_dynamics_fail(d, KM_DYNAMICS_OPEN, error);
}
