/* Singularity curves of the drivers (docs/theory.md 4.19): continuation of the augmented system.
 *
 *   R(q, z) = (e(q); A(q) z; cᵀ z − 1) = 0,   2 r + 1 equations in 2 r + 2 unknowns, c = z at the last point
 *   M = dR = (J 0; (dA/dq) z A; 0 cᵀ),   dA/dq by central differences of J
 *   M t = 0, |t| = 1;   predictor (q, z) + h t;   corrector: Newton's method with tᵀ x = 0
 *
 * It is regular at folds, where A alone is singular (A. Griewank, G. W. Reddien 1984). A curve ends where it closes,
 * and outside the range of a driver. */
#include "kinematics/loop_equations.h"
#include "space/driver_surface.h"
#include "space/real_solve.h"

#include "base/random.h"

#include <string.h>

enum { MOST_NEWTON = 12, MOST_POINTS = 20000 };
static const double difference = 1e-6;   /* step of the central differences: rounding 1e-10, their error 1e-12 */
static const double longest_step = 0.02; /* step of (q, z) */
static const double shortest_step = 1e-7;
static const double converged = 1e-11; /* last correction */

struct km_singularity_curves {
  km_driver_surface *f;
  const km_space_map_def *def;
  km_table *table;
  km_arena arena;
  int count, unknowns;
  double *M, *R, *x, *t, *z, *c; /* [unknowns²], [unknowns] …, [rows] */
  double *forward, *from, *start, *z_from, *z_start, *t_start;
  int *row;
  double **points; /* [point] as km_state_save */
  size_t point_count, capacity;
};

km_singularity_curves *km_singularity_curves_create(km_driver_surface *surface, const km_space_map_def *def,
                                                    km_table *table) {
  km_singularity_curves *v = KM_NEW(km_singularity_curves, 1);
  if (!v)
    return NULL;
  size_t n = (size_t)surface->columns, r = (size_t)surface->rows, u = n + r, saved = KM_SAVED_PER_COLUMN * n;
  *v = (km_singularity_curves){.f = surface, .def = def, .table = table, .unknowns = (int)u};
  km_arena *a = &v->arena;
  v->M = KM_ARENA_NEW(a, double, u *u);
  v->R = KM_ARENA_NEW(a, double, u);
  v->x = KM_ARENA_NEW(a, double, u);
  v->t = KM_ARENA_NEW(a, double, u);
  v->t_start = KM_ARENA_NEW(a, double, u);
  v->z = KM_ARENA_NEW(a, double, r + 1);
  v->c = KM_ARENA_NEW(a, double, r + 1);
  v->z_from = KM_ARENA_NEW(a, double, r + 1);
  v->z_start = KM_ARENA_NEW(a, double, r + 1);
  v->forward = KM_ARENA_NEW(a, double, n *r + 1);
  v->from = KM_ARENA_NEW(a, double, saved);
  v->start = KM_ARENA_NEW(a, double, saved);
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
  km_arena_free(&v->arena);
  km_free(v);
}

int km_singularity_curves_count(const km_singularity_curves *v) {
  return v ? v->count : 0;
}

static double size_of(const double *x, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    sum += x[i] * x[i];
  return sqrt(sum);
}

/* Fills M and R at the state's configuration and z; the last row of M is `last`. */
static void fill(km_singularity_curves *v, const double *last) {
  km_driver_surface *f = v->f;
  int n = f->columns, r = f->rows, u = v->unknowns;
  memset(v->M, 0, (size_t)u * (size_t)u * sizeof *v->M);
  memset(f->step, 0, (size_t)n * sizeof *f->step);
  for (int k = 0; k < n; ++k) {
    for (int side = 0; side < 2; ++side) {
      f->step[k] = side ? -2.0 * difference : difference;
      km_state_move(f->m, f->s, f->sub, f->step);
      km_driver_surface_update(f);
      if (side == 0)
        memcpy(v->forward, f->J, (size_t)(n * r) * sizeof *v->forward);
    }
    f->step[k] = difference;
    km_state_move(f->m, f->s, f->sub, f->step);
    f->step[k] = 0.0;
    for (int i = 0; i < r; ++i)
      for (int j = 0; j < r; ++j)
        v->M[(r + i) * u + k] +=
            (v->forward[f->other[j] * r + i] - f->J[f->other[j] * r + i]) / (2.0 * difference) * v->z[j];
  }
  km_driver_surface_update(f);
  double product = -1.0;
  const double *e = km_state_error(f->s, f->sub);
  for (int i = 0; i < r; ++i) {
    double sum = 0.0;
    for (int k = 0; k < n; ++k)
      v->M[i * u + k] = f->J[k * r + i];
    for (int j = 0; j < r; ++j) {
      v->M[(r + i) * u + n + j] = f->J[f->other[j] * r + i];
      sum += f->J[f->other[j] * r + i] * v->z[j];
    }
    v->R[i] = -e[i];
    v->R[r + i] = -sum;
    v->M[2 * r * u + n + i] = v->c[i];
    product += v->c[i] * v->z[i];
  }
  v->R[2 * r] = -product;
  v->R[u - 1] = 0.0;
  memcpy(v->M + (size_t)(u - 1) * (size_t)u, last, (size_t)u * sizeof *last);
}

/* Newton's method with tᵀ x = 0. `*first`: the first correction. */
static bool correct(km_singularity_curves *v, double *first) {
  km_driver_surface *f = v->f;
  for (int i = 0; i < MOST_NEWTON; ++i) {
    int sign;
    fill(v, v->t);
    if (!km_real_factor(v->M, v->unknowns, v->row, &sign))
      return false;
    km_real_solve(v->M, v->unknowns, v->row, v->R, v->x);
    double correction = size_of(v->x, v->unknowns);
    if (i == 0)
      *first = correction;
    if (!(correction < 1.0))
      return false;
    memcpy(f->step, v->x, (size_t)f->columns * sizeof *f->step);
    km_state_move(f->m, f->s, f->sub, f->step);
    for (int j = 0; j < f->rows; ++j)
      v->z[j] += v->x[f->columns + j];
    if (correction <= converged)
      return true;
  }
  return false;
}

/* Computes t at the present point, in the sense of the last one. */
static bool update_tangent(km_singularity_curves *v) {
  int sign, u = v->unknowns;
  fill(v, v->t);
  if (!km_real_factor(v->M, u, v->row, &sign))
    return false;
  memset(v->R, 0, (size_t)u * sizeof *v->R);
  v->R[u - 1] = 1.0;
  km_real_solve(v->M, u, v->row, v->R, v->x);
  double size = size_of(v->x, u);
  for (int i = 0; i < u; ++i)
    v->t[i] = v->x[i] / size;
  return isfinite(size);
}

/* Distance of the state from a saved configuration, full turns of hinges left out. */
static double distance(const km_singularity_curves *v, const double *saved) {
  km_driver_surface *f = v->f;
  double sum = 0.0;
  km_state_difference(f->s, f->sub, saved, f->step);
  for (int k = 0; k < f->columns; ++k) {
    double d = f->step[k];
    if (km_coordinate_turns(f->m, f->m->column_coordinate[f->sub->column_start + k]))
      d = remainder(d, 2.0 * M_PI);
    sum += d * d;
  }
  return sqrt(sum);
}

static bool add_point(km_singularity_curves *v) {
  const km_driver_surface *f = v->f;
  void *points = v->points;
  double *saved = KM_ARENA_NEW(&v->arena, double, (size_t)(KM_SAVED_PER_COLUMN * f->columns));
  double *row = km_table_add_row(v->table);
  if (!saved || !row || !km_reserve(&points, &v->capacity, v->point_count + 1, sizeof *v->points))
    return false;
  v->points = points;
  v->points[v->point_count++] = saved;
  km_state_save(f->s, f->sub, saved);
  *row++ = v->count;
  for (int c = 0; c < f->m->coordinate_count; ++c)
    row[c] = km_state_value(f->s, c);
  return true;
}

/* True within the ranges of both drivers. */
static bool is_inside(const km_singularity_curves *v) {
  for (int d = 0; d < 2; ++d) {
    const km_space_axis *a = &v->def->axis[d];
    double value = km_state_value(v->f->s, a->coordinate);
    if (value < fmin(a->from, a->to) || value > fmax(a->from, a->to))
      return false;
  }
  return true;
}

/* Follows the curve from its start in the sense of t. Points before the start are written in the second sense only:
 * each sense is a part of the curve. False when out of memory; *is_closed: the curve has returned. */
static bool follow(km_singularity_curves *v, bool *is_closed) {
  km_driver_surface *f = v->f;
  double h = longest_step, travelled = 0.0;
  *is_closed = false;
  for (int i = 0; i < MOST_POINTS && h >= shortest_step;) {
    double first = 0.0;
    km_state_save(f->s, f->sub, v->from);
    memcpy(v->z_from, v->z, (size_t)f->rows * sizeof *v->z);
    memcpy(v->c, v->z, (size_t)f->rows * sizeof *v->z);
    double square = size_of(v->c, f->rows) * size_of(v->c, f->rows);
    for (int j = 0; j < f->rows; ++j)
      v->c[j] /= square;
    for (int k = 0; k < f->columns; ++k)
      f->step[k] = h * v->t[k];
    km_state_move(f->m, f->s, f->sub, f->step);
    for (int j = 0; j < f->rows; ++j)
      v->z[j] += h * v->t[f->columns + j];
    bool is_ok = correct(v, &first) && first <= 0.3 * h && update_tangent(v);
    if (!is_ok) {
      km_state_restore(f->s, f->sub, v->from);
      memcpy(v->z, v->z_from, (size_t)f->rows * sizeof *v->z);
      h *= 0.5;
      continue;
    }
    travelled += h;
    ++i;
    if (!is_inside(v))
      return true;
    if (travelled > 5.0 * longest_step && distance(v, v->start) < h) {
      *is_closed = true;
      return true;
    }
    if (!add_point(v))
      return false;
    h = first < 0.05 * h ? fmin(2.0 * h, longest_step) : h;
  }
  return true;
}

/* z: unit vector of the smallest singular value of A, by inverse iteration with Aᵀ A. */
static bool start_vector(km_singularity_curves *v) {
  km_driver_surface *f = v->f;
  int r = f->rows, sign;
  double *AtA = v->M;
  km_driver_surface_update(f);
  for (int i = 0; i < r; ++i)
    for (int j = 0; j < r; ++j) {
      double sum = i == j ? 1e-14 : 0.0;
      for (int k = 0; k < r; ++k)
        sum += f->J[f->other[i] * r + k] * f->J[f->other[j] * r + k];
      AtA[i * r + j] = sum;
    }
  if (!km_real_factor(AtA, r, v->row, &sign))
    return false;
  for (int i = 0; i < r; ++i)
    v->z[i] = 1.0 / (1.0 + i);
  for (int pass = 0; pass < 4; ++pass) {
    km_real_solve(AtA, r, v->row, v->z, v->c);
    double size = size_of(v->c, r);
    for (int i = 0; i < r; ++i)
      v->z[i] = v->c[i] / size;
  }
  memcpy(v->c, v->z, (size_t)r * sizeof *v->z);
  return true;
}

/* Moves the state to a point of a curve, and computes t. */
static bool move_to_curve(km_singularity_curves *v) {
  uint64_t random = 5;
  double first;
  for (int attempt = 0; attempt < 4; ++attempt) {
    for (int i = 0; i < v->unknowns; ++i)
      v->t[i] = km_uniform(&random);
    if (!start_vector(v))
      return false;
    if (correct(v, &first))
      return update_tangent(v) && update_tangent(v);
  }
  return false;
}

bool km_singularity_curves_add(km_singularity_curves *v, const double *saved, double reach) {
  km_driver_surface *f = v->f;
  km_state_restore(f->s, f->sub, saved);
  for (size_t i = 0; i < v->point_count; ++i)
    if (distance(v, v->points[i]) < reach + longest_step)
      return true;
  if (!move_to_curve(v) || !is_inside(v))
    return true;
  for (size_t i = 0; i < v->point_count; ++i)
    if (distance(v, v->points[i]) < 1.5 * longest_step)
      return true;
  ++v->count;
  km_state_save(f->s, f->sub, v->start);
  memcpy(v->z_start, v->z, (size_t)f->rows * sizeof *v->z);
  memcpy(v->t_start, v->t, (size_t)v->unknowns * sizeof *v->t);
  bool is_closed = false, is_ok = add_point(v) && follow(v, &is_closed);
  if (is_ok && !is_closed) {
    km_state_restore(f->s, f->sub, v->start);
    memcpy(v->z, v->z_start, (size_t)f->rows * sizeof *v->z);
    for (int i = 0; i < v->unknowns; ++i)
      v->t[i] = -v->t_start[i];
    is_ok = follow(v, &is_closed);
  }
  return is_ok;
}
