/* Lists the corners: values of coordinates and times at which forces and prescribed motions change their law
 * (docs/theory.md 11.6). */
#include "dynamics/force_breakpoints.h"

#include "dynamics/prescribed_motion.h"
#include "forces/motion_forces.h"

#include <math.h>
#include <stdlib.h>

/* List in the making; `corners` NULL: the corners are counted. */
typedef struct collector {
  const km_mechanism *mechanism;
  km_corner *corners;
  size_t count;
} collector;

static void add(collector *c, int coordinate, double value, double period) {
  const km_mechanism *m = c->mechanism;
  if (!isfinite(value) || (coordinate >= 0 && (m->ball_of[coordinate] >= 0 || m->held[coordinate])))
    return;
  if (c->corners)
    c->corners[c->count] = (km_corner){coordinate, value, period};
  ++c->count;
}

static void add_curve(collector *c, int coordinate, const km_law_curve *curve) {
  const km_curve_piece *p = curve->pieces;
  for (int i = 0; curve->form == KM_CURVE_PIECES && i < curve->count; ++i) {
    add(c, coordinate, p[i].start, curve->period);
    if (p[i].length > 0.0 && i + 1 == curve->count && curve->period == 0.0)
      add(c, coordinate, p[i].start + p[i].length, 0.0);
  }
}

static void add_rows(collector *c, const double *rows, int count) {
  for (int i = 0; i < count; ++i)
    add(c, KM_CORNER_TIME, rows[2 * i], 0.0);
}

static void add_stops(collector *c, const km_forces *f) {
  const km_mechanism *m = c->mechanism;
  for (int i = 0; i < f->stop_count; ++i) {
    add(c, f->stops[i], m->low[f->stops[i]], 0.0);
    add(c, f->stops[i], m->high[f->stops[i]], 0.0);
  }
}

/* Adds the corners of a law of a time or of the value of one joint. */
static void add_module(collector *c, const km_model_module *module) {
  const bool reads_joint = module->variable == KM_VARIABLE_DISPLACEMENT && module->input_count == 1 &&
                           module->input.coordinate >= 0 && module->inputs[0].weight == 1.0;
  const bool reads_time = module->variable == KM_VARIABLE_TIME;
  if (module->type == KM_MODULE_PID)
    add_curve(c, KM_CORNER_TIME, &module->reference);
  else if (reads_time || reads_joint)
    add_curve(c, reads_time ? KM_CORNER_TIME : module->input.coordinate, &module->curve);
  const bool has_pieces = module->type == KM_MODULE_STIFFNESS || module->type == KM_MODULE_MOTOR;
  for (int k = 0; (reads_time || reads_joint) && has_pieces && k < module->law.knot_count; ++k)
    add(c, reads_time ? KM_CORNER_TIME : module->input.coordinate, module->law.knots[k], 0.0);
}

static void add_loads(collector *c, const km_forces *f) {
  for (int i = 0; i < f->load_count; ++i) {
    const km_load_scale *scale = f->loads[i].scale;
    if (scale)
      add_curve(c, scale->coordinate < 0 ? KM_CORNER_TIME : scale->coordinate, &scale->curve);
  }
}

static void add_prescribed(collector *c) {
  const km_model *model = c->mechanism->model;
  for (int j = 0; j < model->joint_count; ++j) {
    const km_joint_prescribed *p = &model->joints[j].prescribed;
    if (p->law == KM_MOTION_FREE || c->mechanism->held[model->joints[j].first_coordinate])
      continue;
    if (p->law == KM_MOTION_TABLE)
      add_rows(c, p->values, p->count);
    add_curve(c, KM_CORNER_TIME, &p->curve);
  }
}

static void collect(collector *c, const km_dynamics *d) {
  const km_model *model = d->mechanism->model;
  c->count = 0;
  add_stops(c, d->forces);
  for (int i = 0; i < model->module_count; ++i)
    add_module(c, &model->modules[i]);
  add_loads(c, d->forces);
  add_prescribed(c);
}

static int compare_corners(const void *a, const void *b) {
  const km_corner *x = a, *y = b;
  if ((x->period > 0.0) != (y->period > 0.0))
    return (x->period > 0.0) - (y->period > 0.0);
  return x->coordinate != y->coordinate ? (x->coordinate > y->coordinate) - (x->coordinate < y->coordinate)
                                        : (x->value > y->value) - (x->value < y->value);
}

bool km_corners_list(const km_dynamics *d, km_arena *arena, km_corners *out) {
  collector c = {.mechanism = d->mechanism};
  *out = (km_corners){0};
  collect(&c, d);
  c.corners = KM_ARENA_NEW(arena, km_corner, c.count + 1);
  if (!c.corners)
    return false;
  collect(&c, d);
  qsort(c.corners, c.count, sizeof *c.corners, compare_corners);
  *out = (km_corners){.count = (int)c.count, .corners = c.corners};
  while (out->single_count < out->count && c.corners[out->single_count].period == 0.0)
    ++out->single_count;
  return true;
}

/* Index of the first corner without period above a value of a coordinate, by binary search. */
static int first_above(const km_corners *c, int coordinate, double value) {
  const km_corner wanted = {coordinate, value, 0.0};
  int low = 0, high = c->single_count;
  while (low < high) {
    int middle = low + (high - low) / 2;
    if (compare_corners(&c->corners[middle], &wanted) > 0)
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

/* Repetition of a corner above a value, despite the rounding of the division. */
static double repeated_above(const km_corner *corner, double value) {
  double turns = floor((value - corner->value) / corner->period);
  while (corner->value + turns * corner->period > value)
    turns -= 1.0;
  while (corner->value + turns * corner->period <= value)
    turns += 1.0;
  return corner->value + turns * corner->period;
}

double km_corners_above(const km_corners *c, int coordinate, double value) {
  int i = first_above(c, coordinate, value);
  double next = i < c->single_count && c->corners[i].coordinate == coordinate ? c->corners[i].value : HUGE_VAL;
  for (int k = c->single_count; k < c->count && isfinite(value); ++k)
    if (c->corners[k].coordinate == coordinate)
      next = fmin(next, repeated_above(&c->corners[k], value));
  return next;
}

double km_corners_up_to(const km_corners *c, int coordinate, double value) {
  int i = first_above(c, coordinate, value) - 1;
  double last = i >= 0 && c->corners[i].coordinate == coordinate ? c->corners[i].value : -HUGE_VAL;
  for (int k = c->single_count; k < c->count && isfinite(value); ++k)
    if (c->corners[k].coordinate == coordinate)
      last = fmax(last, repeated_above(&c->corners[k], value) - c->corners[k].period);
  return last;
}
