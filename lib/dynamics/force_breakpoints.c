/* Lists the corners: values of coordinates and times at which forces and prescribed motions change their law
 * (docs/theory.md 11.6). */
#include "dynamics/force_breakpoints.h"

#include "dynamics/prescribed_motion.h"
#include "forces/motion_forces.h"

#include <math.h>
#include <stdlib.h>

static void add_value(const km_mechanism *m, km_corners *out, int coordinate, double value) {
  if (isfinite(value) && m->ball_of[coordinate] < 0 && !m->held[coordinate])
    out->corners[out->count++] = (km_corner){coordinate, value};
}

static int compare_corners(const void *a, const void *b) {
  const km_corner *x = a, *y = b;
  return x->coordinate != y->coordinate ? (x->coordinate > y->coordinate) - (x->coordinate < y->coordinate)
                                        : (x->value > y->value) - (x->value < y->value);
}

/* Lists limits with stops and knots of springs, sorted. */
static bool list_values(const km_dynamics *d, km_arena *arena, km_corners *out) {
  const km_mechanism *m = d->mechanism;
  const km_forces *f = d->forces;
  size_t capacity = 2 * (size_t)f->moving->stop_count;
  for (int i = 0; i < f->spring_count; ++i)
    capacity += (size_t)f->springs[i]->law.knot_count;
  out->corners = KM_ARENA_NEW(arena, km_corner, capacity);
  for (int i = 0; i < f->moving->stop_count && out->corners; ++i) {
    add_value(m, out, f->moving->stops[i], m->low[f->moving->stops[i]]);
    add_value(m, out, f->moving->stops[i], m->high[f->moving->stops[i]]);
  }
  for (int i = 0; i < f->spring_count && out->corners; ++i) {
    const km_model_module *spring = f->springs[i];
    const bool measures_joint =
        spring->input_count == 1 && spring->input.coordinate >= 0 && spring->inputs[0].weight == 1.0;
    for (int k = 0; k < spring->law.knot_count && measures_joint; ++k)
      add_value(m, out, spring->input.coordinate, spring->law.knots[k]);
  }
  if (out->corners)
    qsort(out->corners, (size_t)out->count, sizeof *out->corners, compare_corners);
  return out->corners != NULL;
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Appends the times of table rows (time, value) or of knots to out->times; if that is NULL, only counts them. */
static size_t append_times(km_corners *out, const double *times, int count, int stride) {
  for (int i = 0; i < count && out->times; ++i)
    out->times[out->time_count++] = times[stride * i];
  return (size_t)count;
}

/* Lists times of tables and knots of motors and prescribed motions; counts them if there is no memory yet. */
static size_t list_times(const km_dynamics *d, km_corners *out) {
  const km_model *model = d->mechanism->model;
  const km_moving_forces *moving = d->forces->moving;
  size_t count = 0;
  for (int i = 0; i < moving->module_count; ++i) {
    const km_model_module *module = moving->modules[i];
    if (module->type == KM_MODULE_PID && module->reference.is_table)
      count += append_times(out, module->reference.numbers, module->reference.count, 2);
    if (module->type != KM_MODULE_MOTOR || module->variable != KM_VARIABLE_TIME)
      continue;
    count += module->table_count ? append_times(out, module->table, module->table_count, 2)
                                 : append_times(out, module->law.knots, module->law.knot_count, 1);
  }
  for (int j = 0; j < model->joint_count; ++j) {
    const km_joint_prescribed *p = &model->joints[j].prescribed;
    if (p->law == KM_MOTION_TABLE && !d->mechanism->held[model->joints[j].first_coordinate])
      count += append_times(out, p->values, p->count, 2);
  }
  return count;
}

bool km_corners_list(const km_dynamics *d, km_arena *arena, km_corners *out) {
  *out = (km_corners){0};
  size_t count = list_times(d, out);
  out->times = KM_ARENA_NEW(arena, double, count);
  if (!out->times || !list_values(d, arena, out))
    return false;
  list_times(d, out);
  qsort(out->times, count, sizeof *out->times, ascending);
  return true;
}

/* Binary search in the sorted corners. */
int km_corners_above(const km_corners *c, int coordinate, double value) {
  const km_corner wanted = {coordinate, value};
  int low = 0, high = c->count;
  while (low < high) {
    int middle = low + (high - low) / 2;
    if (compare_corners(&c->corners[middle], &wanted) > 0)
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

double km_corners_next(const km_corners *c, double time) {
  int low = 0, high = c->time_count; /* binary search: times below index `low` are ≤ time, those from `high` on are >
                                      * time */
  while (low < high) {
    int middle = low + (high - low) / 2;
    if (c->times[middle] > time)
      high = middle;
    else
      low = middle + 1;
  }
  return low < c->time_count ? c->times[low] : HUGE_VAL;
}
