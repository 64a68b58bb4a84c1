/* Curves on a surface of configurations, followed by continuation (docs/theory.md 4.19).
 *
 *   step  : accepted if its interpolant keeps to 1e-9: h⁴ κ³ / 384, and the first correction is κ h² / 2
 *   roots : of functions along the curve: the margin to ranges and limits, where the curve ends; det K of the other
 *           kinds, where another curve crosses, and det M, where one of its own kind does; the component of t of a
 *           number of the design, which has an extremum there
 *   closed: passes its start, in the direction there */
#include "base/event_locator.h"
#include "base/number/vectors.h"
#include "space/critical_kind.h"
#include "space/curves/curve_search.h"
#include "space/real_solve.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_POINTS = 20000 /* a length of 400 in the longest steps */ };
static const double shortest_step = 1e-7;            /* a shorter one has no digits of a direction: closed to 1e-13 */
static const double most_interpolation_error = 1e-9; /* a tenth of the 1e-8 that outlines are made for */
static const double beside_branch = 1e-6;            /* part of a step: at the branch itself M is singular */

/* Functions whose roots are located. */
enum { MARGIN, INPUT_DETERMINANT, OUTPUT_DETERMINANT, BRANCH_DETERMINANT, NUMBER_RATE, FUNCTIONS };

_Static_assert((int)FUNCTIONS == (int)KM_CURVE_FUNCTIONS, "a value for each function");

/* A root between two points of a curve. */
typedef struct curve_root {
  double h; /* step from the first point */
  int function;
} curve_root;

void km_followed_point_save(km_surface_curves *v, km_followed_point *to) {
  km_driver_surface_save(v->system.f, to->saved);
  memcpy(to->z, v->system.z, (size_t)v->system.vector * sizeof *v->system.z);
  memcpy(to->t, v->system.t, (size_t)v->system.unknowns * sizeof *v->system.t);
}

void km_followed_point_restore(km_surface_curves *v, const km_followed_point *from) {
  double size = km_norm(from->z, v->system.vector);
  km_driver_surface_restore(v->system.f, from->saved);
  memcpy(v->system.z, from->z, (size_t)v->system.vector * sizeof *v->system.z);
  for (int j = 0; j < v->system.vector; ++j)
    v->system.c[j] = v->system.z[j] / (size * size);
  memcpy(v->system.t, from->t, (size_t)v->system.unknowns * sizeof *v->system.t);
}

/* Moves by h along the curve from v->from. False: the curve isn't met; the state's configuration is then undefined. */
static bool step(km_surface_curves *v, double h, double *first) {
  km_followed_point_restore(v, &v->from);
  return km_curve_system_step(&v->system, h, first);
}

/* Notes the row of the present point. False when out of memory. */
static bool note_row(km_surface_curves *v, km_turning_kind critical) {
  const km_driver_surface *f = v->system.f;
  size_t width = km_table_columns(v->table);
  void *rows = v->rows;
  if (!km_reserve(&rows, &v->row_capacity, (v->row_count + 1) * width, sizeof *v->rows))
    return false;
  v->rows = rows;
  double *row = v->rows + v->row_count++ * width;
  *row++ = v->count;
  *row++ = f->number ? f->number->value : (double)v->system.of.kind;
  if (f->number)
    *row++ = critical;
  for (int c = 0; c < f->m->coordinate_count; ++c)
    row[c] = km_state_value(f->s, c);
  for (int d = 0; d < 2; ++d) /* a full turn's value within the range */
    if (f->is_full_turn[d]) {
      double *value = &row[km_driver_surface_coordinate(f, f->control[d])], turn = f->high[d] - f->low[d];
      *value -= turn * floor((*value - f->low[d]) / turn);
    }
  if (f->frame >= 0) {
    km_poses_compute(f->m, f->s);
    row += f->m->coordinate_count;
    km_frame_position(f->m, f->s, f->frame, row);
    for (int i = 3; f->point_surface.radius > 0.0 && i < 5; ++i)
      row[i] = 0.0; /* the chart is chosen at the end */
  }
  return true;
}

bool km_curve_add_point(km_surface_curves *v, km_turning_kind critical) {
  void *found = v->found;
  km_curve_point point = {
      .saved = KM_ARENA_NEW(&v->arena, double, v->system.f->saved_size),
      .tangent = KM_ARENA_NEW(&v->arena, double, (size_t)v->system.f->columns),
      .of = v->system.of,
      .curve = v->count,
  };
  if (!point.saved || !point.tangent || !km_reserve(&found, &v->found_capacity, v->row_count + 1, sizeof *v->found))
    return false;
  v->found = found;
  km_driver_surface_save(v->system.f, point.saved);
  double size = km_norm(v->system.t, v->system.f->columns);
  for (int i = 0; i < v->system.f->columns; ++i)
    point.tangent[i] = v->system.t[i] / size;
  v->found[v->row_count] = point;
  return note_row(v, critical);
}

double km_curve_margin(km_surface_curves *v) {
  const km_surface_curve *of = &v->system.of;
  return km_driver_surface_margin(v->system.f, of->kind == KM_CURVE_LIMIT ? of->column : -1,
                                  of->kind == KM_CURVE_CLEARANCE ? of->column : -1);
}

/* Value of a function at the state's configuration; NaN: it has none on this curve. */
static double function_value(km_surface_curves *v, int function) {
  km_driver_surface *f = v->system.f;
  switch (function) {
  case MARGIN:
    return km_curve_margin(v);
  case BRANCH_DETERMINANT:
    return f->frame < 0 || v->system.vector == 0 ? nan("") : v->system.determinant;
  case NUMBER_RATE:
    return f->number ? v->system.t[f->columns - 1] : nan("");
  default:
    break;
  }
  km_curve_kind kind = function == INPUT_DETERMINANT ? KM_CURVE_INPUT : KM_CURVE_OUTPUT;
  if (f->frame < 0 || v->system.of.kind == kind)
    return nan("");
  km_driver_surface_update_output(f);
  km_driver_surface_matrix(f, kind, v->system.K);
  return km_real_determinant(v->system.K, v->system.order, v->system.row);
}

static void update_values(km_surface_curves *v, double *value) {
  for (int i = 0; i < FUNCTIONS; ++i)
    value[i] = function_value(v, i);
}

/* Value of the located function after a step h from v->from; NaN where the curve isn't met. */
static double located_value(double h, void *context) {
  km_surface_curves *v = context;
  double first;
  return step(v, h, &first) ? function_value(v, v->located) : nan("");
}

static int by_step(const void *a, const void *b) {
  double x = ((const curve_root *)a)->h, y = ((const curve_root *)b)->h;
  return (x > y) - (x < y);
}

/* Locates the roots between v->from and the point at h, where the functions have these values; in their order. */
static int find_roots(km_surface_curves *v, double h, const double *value, curve_root *roots) {
  int count = 0;
  for (int i = 0; i < FUNCTIONS; ++i) {
    if (!(v->from.value[i] * value[i] < 0.0))
      continue;
    v->located = i;
    double root = km_locate_root(located_value, v, 0.0, h, v->from.value[i], value[i]);
    roots[count++] = (curve_root){i == BRANCH_DETERMINANT ? root + beside_branch * h : root, i};
  }
  qsort(roots, (size_t)count, sizeof *roots, by_step);
  return count;
}

/* Notes the extremum of the number at the state's configuration. */
static bool add_extremum(km_surface_curves *v) {
  const km_mechanism *m = v->system.f->m;
  int c = km_driver_surface_coordinate(v->system.f, v->system.f->control[0]);
  double driver = v->system.f->s->q[c];
  void *points = v->critical;
  if (!km_reserve(&points, &v->critical_capacity, (size_t)v->critical_count + 1, sizeof *v->critical))
    return false;
  v->critical = points;
  km_turning_point *point = &v->critical[v->critical_count++];
  *point =
      (km_turning_point){.number = v->system.f->number->value,
                         .driver = (km_coordinate_turns(m, c) ? remainder(driver, 2.0 * M_PI) : driver) / m->factor[c],
                         .curve = v->count};
  return km_critical_kind(v->system.f, &point->kind) && km_curve_add_point(v, point->kind);
}

/* Notes at the newest point which curve crosses there. */
static void note_crossing(km_surface_curves *v, int function) {
  km_curve_point *point = &v->found[v->row_count - 1];
  point->is_crossing =
      function == INPUT_DETERMINANT || function == OUTPUT_DETERMINANT || function == BRANCH_DETERMINANT;
  point->crossing = function == INPUT_DETERMINANT    ? KM_CURVE_INPUT
                    : function == OUTPUT_DETERMINANT ? KM_CURVE_OUTPUT
                                                     : v->system.of.kind;
}

/* Adds the points at the roots between v->from and the point at h. False when out of memory; *is_end: the last one is
 * the curve's end. */
static bool add_roots(km_surface_curves *v, const curve_root *roots, int count, bool *is_end) {
  bool is_ok = true;
  for (int i = 0; is_ok && !*is_end && i < count; ++i) {
    double first;
    *is_end = roots[i].function == MARGIN;
    if (!step(v, roots[i].h, &first) && !step(v, roots[i].h * (1.0 - beside_branch), &first))
      continue;
    is_ok = roots[i].function == NUMBER_RATE ? add_extremum(v) : km_curve_add_point(v, KM_TURNING_NONE);
    if (is_ok)
      note_crossing(v, roots[i].function);
  }
  return is_ok;
}

/* Error of the Hermite interpolant of a step h: h⁴ κ³ / 384 on a circle, whose first correction is κ h² / 2. */
static double interpolation_error(double h, double first) {
  return 8.0 * first * first * first / (384.0 * h * h);
}

/* Prepares the curve's first point. False: the curve has no tangent there. */
static bool begin(km_surface_curves *v) {
  if (!km_curve_system_update_tangent(&v->system))
    return false;
  km_followed_point_save(v, &v->from);
  km_followed_point_save(v, &v->start);
  update_values(v, v->from.value);
  if (fabs(v->from.value[MARGIN]) <= km_at_curve_end)
    v->from.value[MARGIN] = 0.0;
  return true;
}

/* Moves by h, halved until the interpolant is exact enough. *first: the correction. False: no step is long enough. */
static bool step_accurately(km_surface_curves *v, double *h, double *first) {
  for (; *h >= shortest_step; *h *= 0.5)
    if (step(v, *h, first) && interpolation_error(*h, *first) <= most_interpolation_error)
      return true;
  return false;
}

/* True if the last step h of the travelled length has passed the start, in its direction. */
static bool has_passed_start(km_surface_curves *v, double h, double travelled) {
  const km_driver_surface *f = v->system.f;
  return travelled > 3.0 * h && km_dot(v->system.t, v->start.t, f->columns) > 0.0 &&
         km_driver_surface_difference(f, v->start.saved, f->step) < h &&
         km_dot(f->step, v->system.t, f->columns) >= 0.0;
}

/* Shortens the step h that has passed the start, so that it ends there. False: the curve isn't met. */
static bool end_at_start(km_surface_curves *v, double *h) {
  const km_driver_surface *f = v->system.f;
  double first;
  *h -= km_dot(f->step, v->system.t, f->columns);
  return step(v, *h, &first);
}

/* Adds the points of the step h: those at roots, and its end, where the next one begins. `is_last`: none does. *is_end:
 * the curve ends at a root; *is_over: no step follows. False when out of memory. */
static bool add_step(km_surface_curves *v, double h, bool is_last, bool *is_end, bool *is_over) {
  double value[FUNCTIONS], first;
  curve_root roots[FUNCTIONS];
  update_values(v, value);
  int count = find_roots(v, h, value, roots);
  if (count > 0 && !add_roots(v, roots, count, is_end))
    return false;
  *is_over = *is_end || is_last || value[MARGIN] < 0.0 || (count > 0 && !step(v, h, &first));
  if (*is_over)
    return true;
  if (!km_curve_add_point(v, KM_TURNING_NONE))
    return false;
  if (km_driver_surface_exchange(v->system.f) && km_curve_system_update_tangent(&v->system))
    update_values(v, value);
  km_followed_point_save(v, &v->from);
  memcpy(v->from.value, value, sizeof value);
  return true;
}

bool km_curve_follow(km_surface_curves *v, bool *is_closed, double *length) {
  const km_driver_surface *f = v->system.f;
  double h = km_longest_curve_step, travelled = 0.0, first;
  bool is_end = false, is_over = !begin(v);
  *length = 0.0;
  *is_closed = false;
  for (int i = 0; i < MOST_POINTS && !is_over && step_accurately(v, &h, &first); ++i) {
    travelled += h;
    *length += km_driver_surface_difference(f, v->from.saved, f->step);
    *is_closed = has_passed_start(v, h, travelled);
    if (*is_closed && !end_at_start(v, &h))
      return true;
    if (!add_step(v, h, *is_closed, &is_end, &is_over))
      return false;
    if (interpolation_error(2.0 * h, 4.0 * first) < most_interpolation_error)
      h = fmin(2.0 * h, km_longest_curve_step);
  }
  *length = is_end ? HUGE_VAL : *length;
  return true;
}
