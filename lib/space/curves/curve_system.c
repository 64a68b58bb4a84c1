/* The system of a curve on a surface of configurations (space/curves/curve_system.h). */
#include "space/curves/curve_system.h"

#include "base/number/vectors.h"
#include "base/random.h"
#include "space/real_solve.h"

#include <string.h>

enum { MOST_NEWTON = 12 };
static const double shift = 1e-14;             /* some roundings of the unit entries of KᵀK, which it keeps regular */
static const double difference = 1e-6;         /* step of the central differences: rounding 1e-10, their error 1e-12 */
static const double converged = 3e-7;          /* last correction: the one after it, about its square, is rounding */
static const double longest_correction = 0.02; /* a longer one, of (q, z), leads to another curve */
static const double longest_start_step = 1.0;  /* step to a curve: radians, sizes, ranges of the number */

bool km_curve_system_create(km_curve_system *y, km_driver_surface *f, km_arena *a) {
  size_t w = (size_t)km_driver_surface_joints(f), u = (size_t)f->columns + w;
  *y = (km_curve_system){.f = f, .order = (int)w};
  y->M = KM_ARENA_NEW(a, double, u *u);
  y->R = KM_ARENA_NEW(a, double, u);
  y->x = KM_ARENA_NEW(a, double, u);
  y->c = KM_ARENA_NEW(a, double, w);
  y->K = KM_ARENA_NEW(a, double, w *w);
  y->forward = KM_ARENA_NEW(a, double, w *w);
  y->e = KM_ARENA_NEW(a, double, w);
  y->number_column = KM_ARENA_NEW(a, double, w);
  y->z = KM_ARENA_NEW(a, double, w);
  y->t = KM_ARENA_NEW(a, double, u);
  y->row = KM_ARENA_NEW(a, int, u);
  return !a->failed;
}

void km_curve_system_choose(km_curve_system *y, const km_surface_curve *of) {
  y->of = *of;
  y->vector = of->kind == KM_CURVE_INPUT || of->kind == KM_CURVE_OUTPUT ? y->order : 0;
  y->unknowns = y->f->columns + y->vector;
}

/* Updates e and J, and K of a singularity, at the state's configuration. */
static void update(km_curve_system *y, double *K) {
  km_driver_surface_update(y->f);
  if (y->of.kind == KM_CURVE_OUTPUT)
    km_driver_surface_update_output(y->f);
  if (y->vector > 0)
    km_driver_surface_matrix(y->f, y->of.kind, K);
}

/* Fills column k of (dK/dq) z, and the number's column of J. False where the number can't have a value. */
static bool fill_differences(km_curve_system *y, int k) {
  km_driver_surface *f = y->f;
  int r = f->rows, w = y->order;
  const double *e = f->e;
  memset(f->step, 0, (size_t)f->columns * sizeof *f->step);
  f->step[k] = difference;
  bool is_ok = km_driver_surface_move(f, f->step);
  update(y, y->forward);
  memcpy(y->e, e, (size_t)r * sizeof *e);
  f->step[k] = -2.0 * difference;
  is_ok = is_ok && km_driver_surface_move(f, f->step);
  update(y, y->K);
  for (int i = 0; i < w; ++i) {
    double sum = 0.0;
    for (int j = 0; j < w; ++j)
      sum += (y->forward[i * w + j] - y->K[i * w + j]) * y->z[j];
    y->M[(r + i) * y->unknowns + k] = sum / (2.0 * difference);
  }
  for (int i = 0; i < r && k == w; ++i)
    y->number_column[i] = (y->e[i] - e[i]) / (2.0 * difference);
  f->step[k] = difference;
  return is_ok && km_driver_surface_move(f, f->step);
}

/* Fills the rows of K z and cᵀ z but for (dK/dq) z. */
static void fill_singular_rows(km_curve_system *y) {
  int n = y->f->columns, r = y->f->rows, w = y->order, u = y->unknowns;
  double product = -1.0;
  for (int i = 0; i < w; ++i) {
    double sum = 0.0;
    for (int j = 0; j < w; ++j) {
      y->M[(r + i) * u + n + j] = y->K[i * w + j];
      sum += y->K[i * w + j] * y->z[j];
    }
    y->R[r + i] = -sum;
    y->M[(r + w) * u + n + i] = y->c[i];
    product += y->c[i] * y->z[i];
  }
  y->R[r + w] = -product;
}

/* Fills the row of a limit or clearance, and returns its scaled error. */
static double fill_bound_row(km_curve_system *y, double *row) {
  km_driver_surface *f = y->f;
  int column = y->of.column;
  if (y->of.kind == KM_CURVE_CLEARANCE) {
    km_kept_clearance_update(&f->kept, f->m, f->s);
    km_driver_surface_add_clearance_row(f, column, row);
    return km_kept_clearance_excess(&f->kept, column) / f->size;
  }
  int c = km_driver_surface_coordinate(f, column);
  if (y->of.is_signed)
    row[column] = 1.0;
  else
    km_driver_surface_add_limited_row(f, column, row);
  double value = y->of.is_signed ? f->s->q[c] : km_driver_surface_limited_value(f, column);
  return (value - y->of.bound) / f->m->unit[c];
}

/* Fills M and R at the state's configuration and z; the last row of M is `last`. */
static bool fill(km_curve_system *y, const double *last) {
  km_driver_surface *f = y->f;
  int n = f->columns, r = f->rows, u = y->unknowns;
  bool is_singular = y->vector > 0;
  memset(y->M, 0, (size_t)u * (size_t)u * sizeof *y->M);
  for (int k = 0; k < n && is_singular; ++k)
    if (!fill_differences(y, k))
      return false;
  update(y, y->K);
  km_driver_surface_rows(f, y->M, u);
  for (int i = 0; i < r; ++i) {
    if (f->number)
      y->M[i * u + n - 1] = y->number_column[i];
    y->R[i] = -f->e[i];
  }
  if (is_singular) {
    fill_singular_rows(y);
  } else {
    y->R[r] = -fill_bound_row(y, y->M + r * u);
  }
  y->R[u - 1] = 0.0;
  memcpy(y->M + (size_t)(u - 1) * (size_t)u, last, (size_t)u * sizeof *last);
  return true;
}

/* One step x of Newton's method with tᵀ x = 0. */
static bool newton_step(km_curve_system *y, double *correction) {
  km_driver_surface *f = y->f;
  int sign;
  if (!fill(y, y->t) || !km_real_factor(y->M, y->unknowns, y->row, &sign))
    return false;
  km_real_solve(y->M, y->unknowns, y->row, y->R, y->x);
  *correction = km_norm(y->x, y->unknowns);
  memcpy(f->step, y->x, (size_t)f->columns * sizeof *f->step);
  if (!isfinite(*correction) || !km_driver_surface_move(f, f->step))
    return false;
  for (int j = 0; j < y->vector; ++j)
    y->z[j] += y->x[f->columns + j];
  return true;
}

/* Newton's method. `*first`: the first correction. */
static bool correct(km_curve_system *y, double *first) {
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double correction;
    if (!newton_step(y, &correction))
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

bool km_curve_system_update_tangent(km_curve_system *y) {
  int sign, u = y->unknowns;
  if (!fill(y, y->t) || !km_real_factor(y->M, u, y->row, &sign))
    return false;
  y->determinant = sign;
  for (int i = 0; i < u; ++i)
    y->determinant *= fabs(y->M[i * u + i]);
  memset(y->R, 0, (size_t)u * sizeof *y->R);
  y->R[u - 1] = 1.0;
  km_real_solve(y->M, u, y->row, y->R, y->x);
  double size = km_norm(y->x, u);
  for (int i = 0; i < u; ++i)
    y->t[i] = y->x[i] / size;
  return isfinite(size);
}

bool km_curve_system_step(km_curve_system *y, double h, double *first) {
  km_driver_surface *f = y->f;
  for (int k = 0; k < f->columns; ++k)
    f->step[k] = h * y->t[k];
  if (!km_driver_surface_move(f, f->step))
    return false;
  for (int j = 0; j < y->vector; ++j)
    y->z[j] += h * y->t[f->columns + j];
  return correct(y, first) && km_curve_system_update_tangent(y) && km_driver_surface_is_closed(f);
}

bool km_curve_system_start_vector(km_curve_system *y) {
  int w = y->order, sign;
  double *square = y->M;
  update(y, y->K);
  for (int i = 0; i < w; ++i)
    for (int j = 0; j < w; ++j) {
      double sum = i == j ? shift : 0.0;
      for (int k = 0; k < w; ++k)
        sum += y->K[k * w + i] * y->K[k * w + j];
      square[i * w + j] = sum;
    }
  if (!km_real_factor(square, w, y->row, &sign))
    return false;
  for (int i = 0; i < w; ++i)
    y->z[i] = 1.0 / (1.0 + i);
  for (int pass = 0; pass < 4; ++pass) {
    km_real_solve(square, w, y->row, y->z, y->c);
    double size = km_norm(y->c, w);
    for (int i = 0; i < w; ++i)
      y->z[i] = y->c[i] / size;
  }
  memcpy(y->c, y->z, (size_t)w * sizeof *y->z);
  return true;
}

bool km_curve_system_enter(km_curve_system *y) {
  uint64_t random = 5;
  for (int i = 0; i < y->unknowns; ++i)
    y->t[i] = km_uniform(&random);
  km_driver_surface_stop_spins(y->f);
  km_driver_surface_update(y->f);
  km_driver_surface_exchange(y->f);
  if (y->vector > 0 && !km_curve_system_start_vector(y))
    return false;
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double correction;
    if (!km_curve_system_update_tangent(y) || !newton_step(y, &correction) || correction > longest_start_step)
      return false;
    if (correction <= converged)
      return km_curve_system_update_tangent(y) && km_driver_surface_is_closed(y->f);
  }
  return false;
}
