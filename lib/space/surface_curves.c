/* Curves on a surface of configurations (docs/theory.md 4.19), by continuation.
 *
 *   singular: R(q, z) = (e(q); K(q) z; cᵀ z − 1) = 0,   c = z at the last point; one unknown more than equations
 *             M = dR = (J 0; (dK/dq) z K; 0 cᵀ),   dK/dq by central differences, and so the number's column of J
 *   limit   : R(q) = (e(q); q_k − bound) = 0,   M = (J; unit row k);   clearance: d(q) − d_least, its gradient
 *   M t = 0, |t| = 1;   predictor (q, z) + h t;   corrector: Newton's method with tᵀ x = 0
 *
 * The augmented system is regular at folds, where K alone is singular (A. Griewank, G. W. Reddien 1984). Roots of
 * functions are located along a curve: the margin to ranges and limits, where the curve ends; det K of the other kinds,
 * where another curve crosses, and det M, where one of its own kind does; the component of t of a number of the design,
 * which has an extremum there. */
#include "space/surface_curves.h"
#include "base/number/cubic.h"
#include "base/number/vectors.h"

#include "base/event_locator.h"
#include "base/random.h"
#include "space/critical_kind.h"
#include "space/real_solve.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_NEWTON = 12, MOST_POINTS = 20000 };
static const double difference = 1e-6;   /* step of the central differences: rounding 1e-10, their error 1e-12 */
static const double longest_step = 0.02; /* step of (q, z) */
static const double shortest_step = 1e-7;
static const double at_end = 1e-9;       /* margin of a start at an end, such as a corner of the ranges */
static const double least_length = 1e-4; /* a shorter curve without ends is a crossing of others: one q for all z */
static const double most_interpolation_error = 1e-9;
static const double converged = 3e-7;          /* last correction: the one after it, about its square, is rounding */
static const double longest_correction = 0.02; /* a longer one, of (q, z), leads to another curve */
static const double beside_branch = 1e-6;      /* part of a step: at the branch itself M is singular */
static const double longest_start_step = 1.0;  /* step to a curve: radians, sizes, ranges of the number */
static const double same_curve = 1e-5;         /* distance from a curve's interpolant, whose error is 1e-9 */
static const double foot_converged = 1e-6;     /* part of the chord */

/* Functions whose roots are located along a curve. */
enum { MARGIN, INPUT_DETERMINANT, OUTPUT_DETERMINANT, BRANCH_DETERMINANT, NUMBER_RATE, FUNCTIONS };

/* A point of a curve: configuration, null vector, tangent and functions. */
typedef struct curve_point {
  double *saved, *z, *t; /* [saved_size], [order], [unknowns] */
  double value[FUNCTIONS];
} curve_point;

/* A root between two points of a curve. */
typedef struct curve_root {
  double h; /* step from the first point */
  int function;
} curve_root;

struct km_surface_curves {
  km_driver_surface *f;
  km_table *table;
  km_arena arena;
  int count, order;          /* order of K */
  km_surface_curve of;       /* the present curve */
  int vector;                /* length of z: order, 0 of a limit */
  int unknowns;              /* columns + vector */
  int watched;               /* function whose root is located */
  double determinant;        /* det M at the last tangent */
  double *M, *R, *x, *c;     /* [unknowns²], [unknowns], [unknowns], [order] */
  double *K, *forward;       /* [order²] K, and K of a forward difference */
  double *e, *number_column; /* [rows] e of a forward difference, ∂e by the number */
  double *z, *t;             /* null vector and tangent of the present configuration */
  curve_point from, start;
  int *row;
  km_curve_point *points; /* [point_count] of all curves; those of the present one as they were found */
  size_t point_count, capacity;
  km_curve_point *found; /* [row_count] points of the present curve */
  size_t found_capacity;
  double *rows; /* [row_count × columns of the table] of the present curve */
  size_t row_count, row_capacity;
  km_turning_point *critical; /* extrema of the number */
  size_t critical_capacity;
  int critical_count;
};

static curve_point new_point(km_arena *a, const km_driver_surface *f, size_t unknowns) {
  return (curve_point){.saved = KM_ARENA_NEW(a, double, f->saved_size),
                       .z = KM_ARENA_NEW(a, double, (size_t)km_driver_surface_joints(f)),
                       .t = KM_ARENA_NEW(a, double, unknowns)};
}

km_surface_curves *km_surface_curves_create(km_driver_surface *surface, km_table *table) {
  km_surface_curves *v = KM_NEW(km_surface_curves, 1);
  if (!v)
    return NULL;
  size_t w = (size_t)km_driver_surface_joints(surface), u = (size_t)surface->columns + w;
  *v = (km_surface_curves){.f = surface, .table = table, .order = (int)w};
  km_arena *a = &v->arena;
  v->M = KM_ARENA_NEW(a, double, u *u);
  v->R = KM_ARENA_NEW(a, double, u);
  v->x = KM_ARENA_NEW(a, double, u);
  v->c = KM_ARENA_NEW(a, double, w);
  v->K = KM_ARENA_NEW(a, double, w *w);
  v->forward = KM_ARENA_NEW(a, double, w *w);
  v->e = KM_ARENA_NEW(a, double, w);
  v->number_column = KM_ARENA_NEW(a, double, w);
  v->z = KM_ARENA_NEW(a, double, w);
  v->t = KM_ARENA_NEW(a, double, u);
  v->from = new_point(a, surface, u);
  v->start = new_point(a, surface, u);
  v->row = KM_ARENA_NEW(a, int, u);
  if (a->failed) {
    km_surface_curves_free(v);
    return NULL;
  }
  return v;
}

void km_surface_curves_free(km_surface_curves *v) {
  if (!v)
    return;
  km_free(v->points);
  km_free(v->found);
  km_free(v->critical);
  km_free(v->rows);
  km_arena_free(&v->arena);
  km_free(v);
}

int km_surface_curves_count(const km_surface_curves *v) {
  return v ? v->count : 0;
}

const km_turning_point *km_surface_curves_critical(const km_surface_curves *v, int *count) {
  *count = v->critical_count;
  return v->critical;
}

const km_curve_point *km_surface_curves_points(const km_surface_curves *v, size_t *count) {
  *count = v->point_count;
  return v->points;
}

/* Updates e and J, and K of a singularity, at the state's configuration. */
static void update(km_surface_curves *v, double *K) {
  km_driver_surface_update(v->f);
  if (v->of.kind == KM_CURVE_OUTPUT)
    km_driver_surface_update_output(v->f);
  if (v->vector > 0)
    km_driver_surface_matrix(v->f, v->of.kind, K);
}

/* Fills column k of (dK/dq) z, and the number's column of J. False where the number can't have a value. */
static bool fill_differences(km_surface_curves *v, int k) {
  km_driver_surface *f = v->f;
  int r = f->rows, w = v->order;
  const double *e = f->e;
  memset(f->step, 0, (size_t)f->columns * sizeof *f->step);
  f->step[k] = difference;
  bool is_ok = km_driver_surface_move(f, f->step);
  update(v, v->forward);
  memcpy(v->e, e, (size_t)r * sizeof *e);
  f->step[k] = -2.0 * difference;
  is_ok = is_ok && km_driver_surface_move(f, f->step);
  update(v, v->K);
  for (int i = 0; i < w; ++i) {
    double sum = 0.0;
    for (int j = 0; j < w; ++j)
      sum += (v->forward[i * w + j] - v->K[i * w + j]) * v->z[j];
    v->M[(r + i) * v->unknowns + k] = sum / (2.0 * difference);
  }
  for (int i = 0; i < r && k == w; ++i)
    v->number_column[i] = (v->e[i] - e[i]) / (2.0 * difference);
  f->step[k] = difference;
  return is_ok && km_driver_surface_move(f, f->step);
}

/* Fills the rows of K z and cᵀ z but for (dK/dq) z. */
static void fill_singular_rows(km_surface_curves *v) {
  int n = v->f->columns, r = v->f->rows, w = v->order, u = v->unknowns;
  double product = -1.0;
  for (int i = 0; i < w; ++i) {
    double sum = 0.0;
    for (int j = 0; j < w; ++j) {
      v->M[(r + i) * u + n + j] = v->K[i * w + j];
      sum += v->K[i * w + j] * v->z[j];
    }
    v->R[r + i] = -sum;
    v->M[(r + w) * u + n + i] = v->c[i];
    product += v->c[i] * v->z[i];
  }
  v->R[r + w] = -product;
}

/* Fills the row of a limit or clearance, and returns its scaled error. */
static double fill_bound_row(km_surface_curves *v, double *row) {
  km_driver_surface *f = v->f;
  int column = v->of.column;
  if (v->of.kind == KM_CURVE_CLEARANCE) {
    km_kept_clearance_update(&f->kept, f->m, f->s);
    km_driver_surface_add_clearance_row(f, column, row);
    return km_kept_clearance_excess(&f->kept, column) / f->size;
  }
  int c = km_driver_surface_coordinate(f, column);
  if (v->of.is_signed)
    row[column] = 1.0;
  else
    km_driver_surface_add_limited_row(f, column, row);
  double value = v->of.is_signed ? f->s->q[c] : km_driver_surface_limited_value(f, column);
  return (value - v->of.bound) / f->m->unit[c];
}

/* Fills M and R at the state's configuration and z; the last row of M is `last`. */
static bool fill(km_surface_curves *v, const double *last) {
  km_driver_surface *f = v->f;
  int n = f->columns, r = f->rows, u = v->unknowns;
  bool is_singular = v->vector > 0;
  memset(v->M, 0, (size_t)u * (size_t)u * sizeof *v->M);
  for (int k = 0; k < n && is_singular; ++k)
    if (!fill_differences(v, k))
      return false;
  update(v, v->K);
  km_driver_surface_rows(f, v->M, u);
  for (int i = 0; i < r; ++i) {
    if (f->number)
      v->M[i * u + n - 1] = v->number_column[i];
    v->R[i] = -f->e[i];
  }
  if (is_singular) {
    fill_singular_rows(v);
  } else {
    v->R[r] = -fill_bound_row(v, v->M + r * u);
  }
  v->R[u - 1] = 0.0;
  memcpy(v->M + (size_t)(u - 1) * (size_t)u, last, (size_t)u * sizeof *last);
  return true;
}

/* One step x of Newton's method with tᵀ x = 0. */
static bool newton_step(km_surface_curves *v, double *correction) {
  km_driver_surface *f = v->f;
  int sign;
  if (!fill(v, v->t) || !km_real_factor(v->M, v->unknowns, v->row, &sign))
    return false;
  km_real_solve(v->M, v->unknowns, v->row, v->R, v->x);
  *correction = km_norm(v->x, v->unknowns);
  memcpy(f->step, v->x, (size_t)f->columns * sizeof *f->step);
  if (!isfinite(*correction) || !km_driver_surface_move(f, f->step))
    return false;
  for (int j = 0; j < v->vector; ++j)
    v->z[j] += v->x[f->columns + j];
  return true;
}

/* Newton's method. `*first`: the first correction. */
static bool correct(km_surface_curves *v, double *first) {
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double correction;
    if (!newton_step(v, &correction))
      return false;
    if (i == 0)
      *first = correction;
    if (correction <= converged)
      return true;
    if (correction > longest_correction)
      return false;
  }
  return false;
}

/* Computes t at the present point, in the sense of the last one. */
static bool update_tangent(km_surface_curves *v) {
  int sign, u = v->unknowns;
  if (!fill(v, v->t) || !km_real_factor(v->M, u, v->row, &sign))
    return false;
  v->determinant = sign;
  for (int i = 0; i < u; ++i)
    v->determinant *= fabs(v->M[i * u + i]);
  memset(v->R, 0, (size_t)u * sizeof *v->R);
  v->R[u - 1] = 1.0;
  km_real_solve(v->M, u, v->row, v->R, v->x);
  double size = km_norm(v->x, u);
  for (int i = 0; i < u; ++i)
    v->t[i] = v->x[i] / size;
  return isfinite(size);
}

static void save_point(km_surface_curves *v, curve_point *to) {
  km_driver_surface_save(v->f, to->saved);
  memcpy(to->z, v->z, (size_t)v->vector * sizeof *v->z);
  memcpy(to->t, v->t, (size_t)v->unknowns * sizeof *v->t);
}

static void restore_point(km_surface_curves *v, const curve_point *from) {
  double size = km_norm(from->z, v->vector);
  km_driver_surface_restore(v->f, from->saved);
  memcpy(v->z, from->z, (size_t)v->vector * sizeof *v->z);
  for (int j = 0; j < v->vector; ++j)
    v->c[j] = v->z[j] / (size * size);
  memcpy(v->t, from->t, (size_t)v->unknowns * sizeof *v->t);
}

/* Moves by h along the curve from v->from. False: the curve isn't met; the state's configuration is then undefined. */
static bool step(km_surface_curves *v, double h, double *first) {
  km_driver_surface *f = v->f;
  restore_point(v, &v->from);
  for (int k = 0; k < f->columns; ++k)
    f->step[k] = h * v->t[k];
  if (!km_driver_surface_move(f, f->step))
    return false;
  for (int j = 0; j < v->vector; ++j)
    v->z[j] += h * v->t[f->columns + j];
  return correct(v, first) && update_tangent(v) && km_driver_surface_is_closed(f);
}

/* ---- Points and the roots between them. */

/* Notes the row of the present point. False when out of memory. */
static bool note_row(km_surface_curves *v, km_turning_kind critical) {
  const km_driver_surface *f = v->f;
  size_t width = km_table_columns(v->table);
  void *rows = v->rows;
  if (!km_reserve(&rows, &v->row_capacity, (v->row_count + 1) * width, sizeof *v->rows))
    return false;
  v->rows = rows;
  double *row = v->rows + v->row_count++ * width;
  *row++ = v->count;
  *row++ = f->number ? f->number->value : (double)v->of.kind;
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

/* Adds the present point and its row. False when out of memory. */
static bool add_point(km_surface_curves *v, km_turning_kind critical) {
  void *found = v->found;
  km_curve_point point = {
      .saved = KM_ARENA_NEW(&v->arena, double, v->f->saved_size),
      .tangent = KM_ARENA_NEW(&v->arena, double, (size_t)v->f->columns),
      .of = v->of,
      .curve = v->count,
  };
  if (!point.saved || !point.tangent || !km_reserve(&found, &v->found_capacity, v->row_count + 1, sizeof *v->found))
    return false;
  v->found = found;
  km_driver_surface_save(v->f, point.saved);
  double size = km_norm(v->t, v->f->columns);
  for (int i = 0; i < v->f->columns; ++i)
    point.tangent[i] = v->t[i] / size;
  v->found[v->row_count] = point;
  return note_row(v, critical);
}

/* Value of a function at the state's configuration; NaN: it has none on this curve. */
static double function_value(km_surface_curves *v, int function) {
  km_driver_surface *f = v->f;
  switch (function) {
  case MARGIN:
    return km_driver_surface_margin(f, v->of.kind == KM_CURVE_LIMIT ? v->of.column : -1,
                                    v->of.kind == KM_CURVE_CLEARANCE ? v->of.column : -1);
  case BRANCH_DETERMINANT:
    return f->frame < 0 || v->vector == 0 ? nan("") : v->determinant;
  case NUMBER_RATE:
    return f->number ? v->t[f->columns - 1] : nan("");
  default:
    break;
  }
  km_curve_kind kind = function == INPUT_DETERMINANT ? KM_CURVE_INPUT : KM_CURVE_OUTPUT;
  if (f->frame < 0 || v->of.kind == kind)
    return nan("");
  km_driver_surface_update_output(f);
  km_driver_surface_matrix(f, kind, v->K);
  return km_real_determinant(v->K, v->order, v->row);
}

static void update_values(km_surface_curves *v, double *value) {
  for (int i = 0; i < FUNCTIONS; ++i)
    value[i] = function_value(v, i);
}

/* Value of the watched function after a step h from v->from; NaN where the curve isn't met. */
static double watched_value(double h, void *context) {
  km_surface_curves *v = context;
  double first;
  return step(v, h, &first) ? function_value(v, v->watched) : nan("");
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
    v->watched = i;
    double root = km_locate_root(watched_value, v, 0.0, h, v->from.value[i], value[i]);
    roots[count++] = (curve_root){i == BRANCH_DETERMINANT ? root + beside_branch * h : root, i};
  }
  qsort(roots, (size_t)count, sizeof *roots, by_step);
  return count;
}

/* Notes the extremum of the number at the state's configuration. */
static bool add_extremum(km_surface_curves *v) {
  const km_mechanism *m = v->f->m;
  int c = km_driver_surface_coordinate(v->f, v->f->control[0]);
  double driver = v->f->s->q[c];
  void *points = v->critical;
  if (!km_reserve(&points, &v->critical_capacity, (size_t)v->critical_count + 1, sizeof *v->critical))
    return false;
  v->critical = points;
  km_turning_point *point = &v->critical[v->critical_count++];
  *point =
      (km_turning_point){.number = v->f->number->value,
                         .driver = (km_coordinate_turns(m, c) ? remainder(driver, 2.0 * M_PI) : driver) / m->factor[c],
                         .curve = v->count};
  return km_critical_kind(v->f, &point->kind) && add_point(v, point->kind);
}

/* Notes at the newest point which curve crosses there. */
static void note_crossing(km_surface_curves *v, int function) {
  km_curve_point *point = &v->found[v->row_count - 1];
  point->is_crossing =
      function == INPUT_DETERMINANT || function == OUTPUT_DETERMINANT || function == BRANCH_DETERMINANT;
  point->crossing = function == INPUT_DETERMINANT    ? KM_CURVE_INPUT
                    : function == OUTPUT_DETERMINANT ? KM_CURVE_OUTPUT
                                                     : v->of.kind;
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
    is_ok = roots[i].function == NUMBER_RATE ? add_extremum(v) : add_point(v, KM_TURNING_NONE);
    if (is_ok)
      note_crossing(v, roots[i].function);
  }
  return is_ok;
}

/* Error of the Hermite interpolant of a step h: h⁴ κ³ / 384 on a circle, whose first correction is κ h² / 2. */
static double interpolation_error(double h, double first) {
  return 8.0 * first * first * first / (384.0 * h * h);
}

/* Follows the curve from its start in the sense of t. False when out of memory; *is_closed: the curve has returned;
 * *length: of the configurations, infinite with an end. */
static bool follow(km_surface_curves *v, bool *is_closed, double *length) {
  km_driver_surface *f = v->f;
  double h = longest_step, travelled = 0.0, value[FUNCTIONS];
  *length = 0.0;
  curve_root roots[FUNCTIONS];
  *is_closed = false;
  if (!update_tangent(v))
    return true;
  save_point(v, &v->from);
  save_point(v, &v->start);
  update_values(v, v->from.value);
  if (fabs(v->from.value[MARGIN]) <= at_end)
    v->from.value[MARGIN] = 0.0;
  for (int i = 0; i < MOST_POINTS && h >= shortest_step;) {
    double first = 0.0;
    if (!step(v, h, &first) || interpolation_error(h, first) > most_interpolation_error) {
      h *= 0.5;
      continue;
    }
    travelled += h;
    *length += km_driver_surface_difference(f, v->from.saved, f->step);
    ++i;
    bool is_end = false;
    *is_closed = travelled > 3.0 * h && km_dot(v->t, v->start.t, f->columns) > 0.0 &&
                 km_driver_surface_difference(f, v->start.saved, f->step) < h &&
                 km_dot(f->step, v->t, f->columns) >= 0.0;
    if (*is_closed) { /* passed: a step to the start */
      h -= km_dot(f->step, v->t, f->columns);
      if (!step(v, h, &first))
        return true;
    }
    update_values(v, value);
    int count = find_roots(v, h, value, roots);
    if (count > 0 && !add_roots(v, roots, count, &is_end))
      return false;
    *length = is_end ? HUGE_VAL : *length;
    if (is_end || *is_closed || value[MARGIN] < 0.0 || (count > 0 && !step(v, h, &first)))
      return true;
    if (!add_point(v, KM_TURNING_NONE))
      return false;
    if (km_driver_surface_exchange(f) && update_tangent(v))
      update_values(v, value);
    save_point(v, &v->from);
    memcpy(v->from.value, value, sizeof value);
    if (interpolation_error(2.0 * h, 4.0 * first) < most_interpolation_error)
      h = fmin(2.0 * h, longest_step);
  }
  return true;
}

/* z: unit vector of the smallest singular value of K, by inverse iteration with Kᵀ K. */
static bool start_vector(km_surface_curves *v) {
  int w = v->order, sign;
  double *square = v->M;
  update(v, v->K);
  for (int i = 0; i < w; ++i)
    for (int j = 0; j < w; ++j) {
      double sum = i == j ? 1e-14 : 0.0;
      for (int k = 0; k < w; ++k)
        sum += v->K[k * w + i] * v->K[k * w + j];
      square[i * w + j] = sum;
    }
  if (!km_real_factor(square, w, v->row, &sign))
    return false;
  for (int i = 0; i < w; ++i)
    v->z[i] = 1.0 / (1.0 + i);
  for (int pass = 0; pass < 4; ++pass) {
    km_real_solve(square, w, v->row, v->z, v->c);
    double size = km_norm(v->c, w);
    for (int i = 0; i < w; ++i)
      v->z[i] = v->c[i] / size;
  }
  memcpy(v->c, v->z, (size_t)w * sizeof *v->z);
  return true;
}

/* Moves the state to the nearest point of a curve by minimum-norm steps, Newton's method with the last row of M in its
 * null space, and computes t. */
static bool move_to_curve(km_surface_curves *v) {
  uint64_t random = 5;
  for (int i = 0; i < v->unknowns; ++i)
    v->t[i] = km_uniform(&random);
  km_driver_surface_stop_spins(v->f);
  km_driver_surface_update(v->f);
  km_driver_surface_exchange(v->f);
  if (v->vector > 0 && !start_vector(v))
    return false;
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double correction;
    if (!update_tangent(v) || !newton_step(v, &correction) || correction > longest_start_step)
      return false;
    if (correction <= converged)
      return update_tangent(v) && km_driver_surface_is_closed(v->f);
  }
  return false;
}

static bool is_same_curve(const km_surface_curve *a, const km_surface_curve *b) {
  return a->kind == b->kind && a->column == b->column && a->bound == b->bound && a->is_signed == b->is_signed;
}

/* Distance of the state from the Hermite interpolant between two points of a curve, from which it differs by the steps
 * from[columns] and to[columns], at the foot of its perpendicular; infinity beyond the ends. */
static double distance_from_chord(km_surface_curves *v, const km_curve_point *p, const km_curve_point *next) {
  km_driver_surface *f = v->f;
  double *from = v->x, *to = v->R, length = 0.0, u = 0.5, square = HUGE_VAL;
  km_driver_surface_difference(f, p->saved, from);
  km_driver_surface_difference(f, next->saved, to);
  for (int k = 0; k < f->columns; ++k)
    length += (from[k] - to[k]) * (from[k] - to[k]);
  length = sqrt(length);
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double along = 0.0, rate = 0.0;
    square = 0.0;
    for (int k = 0; k < f->columns; ++k) {
      double c[4];
      km_cubic_hermite(0.0, length * p->tangent[k], from[k] - to[k], length * next->tangent[k], c);
      double away = from[k] - km_cubic(c, u), d = km_cubic_rate(c, u);
      along += away * d;
      rate += d * d;
      square += away * away;
    }
    if (fabs(along) < foot_converged * rate)
      break;
    u = fmin(fmax(u + along / rate, -0.5), 1.5);
  }
  return fabs(u - 0.5) < 0.5 + foot_converged ? sqrt(square) : HUGE_VAL;
}

/* True if the state is on a known curve of this kind. */
static bool is_on_known(km_surface_curves *v) {
  for (size_t i = 0; i + 1 < v->point_count; ++i)
    if (is_same_curve(&v->points[i].of, &v->of) && v->points[i + 1].curve == v->points[i].curve &&
        km_driver_surface_difference(v->f, v->points[i].saved, v->f->step) < 1.5 * longest_step &&
        distance_from_chord(v, &v->points[i], &v->points[i + 1]) < same_curve)
      return true;
  return false;
}

/* True if a point of a known curve of this kind is nearer to the state than `reach`. */
static bool is_known(const km_surface_curves *v, double reach) {
  for (size_t i = 0; i < v->point_count; ++i)
    if (is_same_curve(&v->points[i].of, &v->of) &&
        km_driver_surface_difference(v->f, v->points[i].saved, v->f->step) < reach)
      return true;
  return false;
}

/* Writes the found points and their rows from `first` in steps of ±1 until `end`. False when out of memory. */
static bool write_points(km_surface_curves *v, size_t first, size_t end, int by) {
  size_t width = km_table_columns(v->table);
  void *points = v->points;
  if (!km_reserve(&points, &v->capacity, v->point_count + v->row_count + 1, sizeof *v->points))
    return false;
  v->points = points;
  for (size_t i = first; i != end; i += (size_t)by) {
    double *row = km_table_add_row(v->table);
    if (!row)
      return false;
    memcpy(row, v->rows + i * width, width * sizeof *row);
    km_curve_point *point = &v->points[v->point_count++];
    *point = v->found[i];
    for (int k = 0; k < v->f->columns; ++k)
      point->tangent[k] *= by;
  }
  return true;
}

static void choose(km_surface_curves *v, const km_surface_curve *of) {
  v->of = *of;
  v->vector = of->kind == KM_CURVE_INPUT || of->kind == KM_CURVE_OUTPUT ? v->order : 0;
  v->unknowns = v->f->columns + v->vector;
}

bool km_surface_curves_add(km_surface_curves *v, const km_surface_curve *of, const double *saved, double reach) {
  km_driver_surface *f = v->f;
  choose(v, of);
  km_driver_surface_restore(f, saved);
  if (is_known(v, reach + longest_step) || !move_to_curve(v) || function_value(v, MARGIN) < -at_end || is_on_known(v))
    return true;
  ++v->count;
  v->row_count = 0;
  save_point(v, &v->start);
  bool is_closed = false;
  double length, other_length;
  int critical_count = v->critical_count;
  if (!add_point(v, KM_TURNING_NONE) || !follow(v, &is_closed, &length))
    return false;
  size_t first = v->row_count;
  if (is_closed && length > least_length)
    return write_points(v, 0, first, 1) && write_points(v, 0, 1, 1);
  restore_point(v, &v->start);
  for (int i = 0; i < v->unknowns; ++i)
    v->t[i] = -v->t[i];
  if (!follow(v, &is_closed, &other_length))
    return false;
  if (length + other_length < least_length) {
    --v->count;
    v->critical_count = critical_count;
    return true;
  }
  return write_points(v, first - 1, (size_t)-1, -1) && write_points(v, first, v->row_count, 1);
}

bool km_surface_curves_leave(km_surface_curves *v, size_t i, double distance, bool *is_point) {
  km_driver_surface *f = v->f;
  *is_point = i < v->point_count;
  if (!*is_point || v->points[i].of.kind != KM_CURVE_INPUT)
    return false;
  choose(v, &v->points[i].of);
  km_driver_surface_restore(f, v->points[i].saved);
  if (!start_vector(v))
    return false;
  memset(f->step, 0, (size_t)f->columns * sizeof *f->step);
  for (int k = 0; k < v->order; ++k)
    f->step[k] = distance * v->z[k];
  return km_driver_surface_move(f, f->step);
}
