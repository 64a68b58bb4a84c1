/* Singularity curves (docs/theory.md 4.19): continuation of the augmented system.
 *
 *   R(q, z) = (e(q); K(q) z; cᵀ z − 1) = 0,   c = z at the last point; one unknown more than equations
 *   M = dR = (J 0; (dK/dq) z K; 0 cᵀ),   dK/dq by central differences, and so the number's column of J
 *   M t = 0, |t| = 1;   predictor (q, z) + h t;   corrector: Newton's method with tᵀ x = 0
 *
 * It is regular at folds, where K alone is singular (A. Griewank, G. W. Reddien 1984). A curve ends where it closes,
 * and outside the range of a control. Where a number of the design is a control, extrema of the number are located:
 * roots of its component of t. */
#include "space/singularity_curves.h"
#include "base/number/vectors.h"

#include "base/event_locator.h"
#include "base/random.h"
#include "space/critical_kind.h"
#include "space/real_solve.h"

#include <string.h>

enum { MOST_NEWTON = 12, MOST_POINTS = 20000 };
static const double difference = 1e-6;   /* step of the central differences: rounding 1e-10, their error 1e-12 */
static const double longest_step = 0.02; /* step of (q, z) */
static const double shortest_step = 1e-7;
static const double converged = 3e-7;          /* last correction: the one after it, about its square, is rounding */
static const double longest_correction = 0.02; /* a longer one, of (q, z), leads to another curve */
static const double longest_start_step = 1.0;  /* step to a curve: radians, sizes, ranges of the number */

/* A point of a curve: configuration, null vector and tangent. */
typedef struct curve_point {
  double *saved, *z, *t; /* [saved_size], [order], [unknowns] */
} curve_point;

struct km_singularity_curves {
  km_driver_surface *f;
  km_table *table;
  km_arena arena;
  int count, unknowns, order; /* order of K */
  km_singularity_kind kind;   /* kind of the present curve */
  double *M, *R, *x, *c;      /* [unknowns²], [unknowns], [unknowns], [order] */
  double *K, *forward;        /* [order²] K, and K of a forward difference */
  double *e, *number_column;  /* [rows] e of a forward difference, ∂e by the number */
  double *z, *t;              /* null vector and tangent of the present configuration */
  curve_point from, start;
  int *row;
  double **points;                 /* [point] saved configurations */
  km_singularity_kind *point_kind; /* [point] */
  size_t point_count, capacity, kind_capacity;
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

km_singularity_curves *km_singularity_curves_create(km_driver_surface *surface, km_table *table) {
  km_singularity_curves *v = KM_NEW(km_singularity_curves, 1);
  if (!v)
    return NULL;
  size_t w = (size_t)km_driver_surface_joints(surface), u = (size_t)surface->columns + w;
  *v = (km_singularity_curves){.f = surface, .table = table, .unknowns = (int)u, .order = (int)w};
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
    km_singularity_curves_free(v);
    return NULL;
  }
  return v;
}

void km_singularity_curves_free(km_singularity_curves *v) {
  if (!v)
    return;
  km_free(v->points);
  km_free(v->point_kind);
  km_free(v->critical);
  km_free(v->rows);
  km_arena_free(&v->arena);
  km_free(v);
}

int km_singularity_curves_count(const km_singularity_curves *v) {
  return v ? v->count : 0;
}

const km_turning_point *km_singularity_curves_critical(const km_singularity_curves *v, int *count) {
  *count = v->critical_count;
  return v->critical;
}

/* Updates e, J and K at the state's configuration. */
static void update(km_singularity_curves *v, double *K) {
  km_driver_surface_update(v->f);
  if (v->kind == KM_SINGULARITY_OUTPUT)
    km_driver_surface_update_output(v->f);
  km_driver_surface_matrix(v->f, v->kind, K);
}

/* Fills column k of (dK/dq) z, and the number's column of J. False where the number can't have a value. */
static bool fill_differences(km_singularity_curves *v, int k) {
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

/* Fills M and R at the state's configuration and z; the last row of M is `last`. */
static bool fill(km_singularity_curves *v, const double *last) {
  km_driver_surface *f = v->f;
  int n = f->columns, r = f->rows, w = v->order, u = v->unknowns;
  memset(v->M, 0, (size_t)u * (size_t)u * sizeof *v->M);
  for (int k = 0; k < n; ++k)
    if (!fill_differences(v, k))
      return false;
  update(v, v->K);
  const double *e = f->e;
  for (int i = 0; i < r; ++i) {
    for (int k = 0; k < n; ++k)
      v->M[i * u + k] = k == w ? v->number_column[i] : f->J[k * r + i];
    v->R[i] = -e[i];
  }
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
  v->R[u - 1] = 0.0;
  memcpy(v->M + (size_t)(u - 1) * (size_t)u, last, (size_t)u * sizeof *last);
  return true;
}

/* One step x of Newton's method with tᵀ x = 0. */
static bool newton_step(km_singularity_curves *v, double *correction) {
  km_driver_surface *f = v->f;
  int sign;
  if (!fill(v, v->t) || !km_real_factor(v->M, v->unknowns, v->row, &sign))
    return false;
  km_real_solve(v->M, v->unknowns, v->row, v->R, v->x);
  *correction = km_norm(v->x, v->unknowns);
  memcpy(f->step, v->x, (size_t)f->columns * sizeof *f->step);
  if (!isfinite(*correction) || !km_driver_surface_move(f, f->step))
    return false;
  for (int j = 0; j < v->order; ++j)
    v->z[j] += v->x[f->columns + j];
  return true;
}

/* Newton's method. `*first`: the first correction. */
static bool correct(km_singularity_curves *v, double *first) {
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
static bool update_tangent(km_singularity_curves *v) {
  int sign, u = v->unknowns;
  if (!fill(v, v->t) || !km_real_factor(v->M, u, v->row, &sign))
    return false;
  memset(v->R, 0, (size_t)u * sizeof *v->R);
  v->R[u - 1] = 1.0;
  km_real_solve(v->M, u, v->row, v->R, v->x);
  double size = km_norm(v->x, u);
  for (int i = 0; i < u; ++i)
    v->t[i] = v->x[i] / size;
  return isfinite(size);
}

static void save_point(km_singularity_curves *v, curve_point *to) {
  km_driver_surface_save(v->f, to->saved);
  memcpy(to->z, v->z, (size_t)v->order * sizeof *v->z);
  memcpy(to->t, v->t, (size_t)v->unknowns * sizeof *v->t);
}

static void restore_point(km_singularity_curves *v, const curve_point *from) {
  km_driver_surface_restore(v->f, from->saved);
  memcpy(v->z, from->z, (size_t)v->order * sizeof *v->z);
  memcpy(v->t, from->t, (size_t)v->unknowns * sizeof *v->t);
}

/* Moves by h along the curve from v->from. False: the curve isn't met; the state's configuration is then undefined. */
static bool step(km_singularity_curves *v, double h, double *first) {
  km_driver_surface *f = v->f;
  restore_point(v, &v->from);
  double size = km_norm(v->z, v->order);
  for (int j = 0; j < v->order; ++j)
    v->c[j] = v->z[j] / (size * size);
  for (int k = 0; k < f->columns; ++k)
    f->step[k] = h * v->t[k];
  if (!km_driver_surface_move(f, f->step))
    return false;
  for (int j = 0; j < v->order; ++j)
    v->z[j] += h * v->t[f->columns + j];
  return correct(v, first) && update_tangent(v);
}

/* Notes the row of the present point. False when out of memory. */
static bool note_row(km_singularity_curves *v, km_turning_kind critical) {
  const km_driver_surface *f = v->f;
  size_t width = km_table_columns(v->table);
  void *rows = v->rows;
  if (!km_reserve(&rows, &v->row_capacity, (v->row_count + 1) * width, sizeof *v->rows))
    return false;
  v->rows = rows;
  double *row = v->rows + v->row_count++ * width;
  *row++ = v->count;
  *row++ = f->number ? f->number->value : (double)v->kind;
  if (f->number)
    *row++ = critical;
  for (int c = 0; c < f->m->coordinate_count; ++c)
    row[c] = km_state_value(f->s, c);
  if (f->frame >= 0) {
    km_poses_compute(f->m, f->s);
    km_frame_position(f->m, f->s, f->frame, row + f->m->coordinate_count);
  }
  return true;
}

static bool add_point(km_singularity_curves *v) {
  void *points = v->points, *kinds = v->point_kind;
  double *saved = KM_ARENA_NEW(&v->arena, double, v->f->saved_size);
  if (!saved || !km_reserve(&points, &v->capacity, v->point_count + 1, sizeof *v->points))
    return false;
  v->points = points;
  if (!km_reserve(&kinds, &v->kind_capacity, v->point_count + 1, sizeof *v->point_kind))
    return false;
  v->point_kind = kinds;
  v->point_kind[v->point_count] = v->kind;
  v->points[v->point_count++] = saved;
  km_driver_surface_save(v->f, saved);
  return note_row(v, KM_TURNING_NONE);
}

/* The number's component of t after a step h from v->from; NaN where the curve isn't met. */
static double number_rate(double h, void *context) {
  km_singularity_curves *v = context;
  double first;
  return step(v, h, &first) ? v->t[v->f->columns - 1] : nan("");
}

/* Locates the extremum of the number between v->from and the point at h, and notes it. `last`: the number's component
 * of t there. The state stays at the extremum. */
static bool add_extremum(km_singularity_curves *v, double h, double last) {
  double first;
  if (!step(v, km_locate_root(number_rate, v, 0.0, h, v->from.t[v->f->columns - 1], last), &first))
    return true;
  const km_mechanism *m = v->f->m;
  int c = km_driver_surface_coordinate(v->f, v->f->control[0]);
  double driver = v->f->s->q[c];
  if (!km_driver_surface_is_inside(v->f))
    return true;
  void *points = v->critical;
  if (!km_reserve(&points, &v->critical_capacity, (size_t)v->critical_count + 1, sizeof *v->critical))
    return false;
  v->critical = points;
  km_turning_point *point = &v->critical[v->critical_count++];
  *point =
      (km_turning_point){.number = v->f->number->value,
                         .driver = (km_coordinate_turns(m, c) ? remainder(driver, 2.0 * M_PI) : driver) / m->factor[c],
                         .curve = v->count};
  return km_critical_kind(v->f, &point->kind) && note_row(v, point->kind);
}

/* Follows the curve from its start in the sense of t. False when out of memory; *is_closed: the curve has returned. */
static bool follow(km_singularity_curves *v, bool *is_closed) {
  km_driver_surface *f = v->f;
  int at = f->columns - 1;
  double h = longest_step, travelled = 0.0;
  *is_closed = false;
  save_point(v, &v->from);
  for (int i = 0; i < MOST_POINTS && h >= shortest_step;) {
    double first = 0.0;
    if (!step(v, h, &first) || first > 0.3 * h) {
      h *= 0.5;
      continue;
    }
    travelled += h;
    ++i;
    if (f->number && v->t[at] * v->from.t[at] < 0.0) {
      if (!add_extremum(v, h, v->t[at]))
        return false;
      if (!step(v, h, &first))
        return true;
    }
    if (!km_driver_surface_is_inside(f))
      return true;
    *is_closed = travelled > 5.0 * longest_step && km_driver_surface_difference(f, v->start.saved, f->step) < h;
    if (*is_closed)
      return true;
    if (!add_point(v))
      return false;
    save_point(v, &v->from);
    h = first < 0.05 * h ? fmin(2.0 * h, longest_step) : h;
  }
  return true;
}

/* z: unit vector of the smallest singular value of K, by inverse iteration with Kᵀ K. */
static bool start_vector(km_singularity_curves *v) {
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
static bool move_to_curve(km_singularity_curves *v) {
  uint64_t random = 5;
  for (int i = 0; i < v->unknowns; ++i)
    v->t[i] = km_uniform(&random);
  if (!start_vector(v))
    return false;
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double correction;
    if (!update_tangent(v) || !newton_step(v, &correction) || correction > longest_start_step)
      return false;
    if (correction <= converged)
      return update_tangent(v);
  }
  return false;
}

/* True if a point of a known curve of this kind is nearer to the state than `reach`. */
static bool is_known(const km_singularity_curves *v, double reach) {
  for (size_t i = 0; i < v->point_count; ++i)
    if (v->point_kind[i] == v->kind && km_driver_surface_difference(v->f, v->points[i], v->f->step) < reach)
      return true;
  return false;
}

/* Writes the noted rows from `first` in steps of ±1 until `end`. False when out of memory. */
static bool write_rows(km_singularity_curves *v, size_t first, size_t end, int by) {
  size_t width = km_table_columns(v->table);
  for (size_t i = first; i != end; i += (size_t)by) {
    double *row = km_table_add_row(v->table);
    if (!row)
      return false;
    memcpy(row, v->rows + i * width, width * sizeof *row);
  }
  return true;
}

bool km_singularity_curves_add(km_singularity_curves *v, km_singularity_kind kind, const double *saved, double reach) {
  km_driver_surface *f = v->f;
  v->kind = kind;
  km_driver_surface_restore(f, saved);
  if (is_known(v, reach + longest_step) || !move_to_curve(v) || !km_driver_surface_is_inside(f) ||
      is_known(v, 1.5 * longest_step))
    return true;
  ++v->count;
  v->row_count = 0;
  save_point(v, &v->start);
  bool is_closed = false;
  if (!add_point(v) || !follow(v, &is_closed))
    return false;
  size_t first = v->row_count;
  if (is_closed)
    return write_rows(v, 0, first, 1) && write_rows(v, 0, 1, 1);
  restore_point(v, &v->start);
  for (int i = 0; i < v->unknowns; ++i)
    v->t[i] = -v->t[i];
  return follow(v, &is_closed) && write_rows(v, first - 1, (size_t)-1, -1) && write_rows(v, first, v->row_count, 1);
}

bool km_singularity_curves_leave(km_singularity_curves *v, size_t i, double distance, bool *is_point) {
  km_driver_surface *f = v->f;
  *is_point = i < v->point_count;
  if (!*is_point || v->point_kind[i] != KM_SINGULARITY_INPUT)
    return false;
  v->kind = KM_SINGULARITY_INPUT;
  km_driver_surface_restore(f, v->points[i]);
  if (!start_vector(v))
    return false;
  memset(f->step, 0, (size_t)f->columns * sizeof *f->step);
  for (int k = 0; k < v->order; ++k)
    f->step[k] = distance * v->z[k];
  return km_driver_surface_move(f, f->step);
}
