/* What many motions have of a step or of a coordinate: of a matrix with few entries by sparse Q R of its primary rows, to which
 * all motions are at right angles, or of the null vectors, whichever fills R less. */
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/normal_equations.h"
#include "linalg/sparse/sparse_lu.h"
#include "linalg/sparse/sparse_qr.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Primary rows are independent: each has a pivot. */
static const double spanned = 1e-14;
/* What is left of 1 by taking squares out of it keeps that much of rounding. */
static const double rounding = 1e-13;

/* The rows, to be factored, in the order of all rows that is given; NULL: in that of their pivots. The independent columns behind the
 * first `count` are left out. NULL where SPQR isn't installed or memory is out. */
static km_sparse_qr *rows_of(const km_partition *p, const double *matrix, const double *weight, int count,
                             const long *order) {
  km_sparse_qr *q = NULL;
  km_error error;
  bool *left_out = KM_NEW(bool, (size_t)p->columns + 1);
  if (left_out && !km_sparse_qr_create(p->columns, p->rank, p->sparse->start[p->columns], &q, &error)) {
    for (int k = p->rank + count; k < p->columns; ++k)
      left_out[p->column[k]] = true;
    for (int i = 0, k = 0; i < p->rows && k < p->rank; ++i) {
      int row = order ? (int)order[i] : p->row[i];
      if (p->sparse->step_of[row] >= 0)
        km_sparse_fill_row(p->sparse, matrix, weight, left_out, row, k++, km_sparse_qr_columns(q));
    }
  }
  km_free(left_out);
  return q;
}

/* Σ over all rows of N, of the first `count` null vectors, of the squared number of entries; it ends beyond `most`. */
static double crowd_of_null(const km_partition *p, int count, double most, int *entries) {
  const km_sparse *s = p->sparse;
  int *met = KM_NEW(int, (size_t)p->rank + 1);
  double sum = met ? count : HUGE_VAL;
  *entries = count;
  for (int k = 0; k < count && sum <= most; ++k) {
    km_entry_range b = km_sparse_b(p, k);
    for (int i = b.start; i < b.end; ++i)
      sum += 2.0 * met[s->b_store.index[i]]++ + 1.0; /* (n + 1)² − n² */
    *entries += b.end - b.start;
  }
  km_free(met);
  return sum;
}

static int ascending(const void *a, const void *b) {
  long x = *(const long *)a, y = *(const long *)b;
  return (x > y) - (x < y);
}

/* Null vector k times the weights becomes column k, in work[columns]. */
static void fill_null(const km_partition *p, const double *weight, int k, double *work, km_columns out) {
  const km_sparse *s = p->sparse;
  km_entry_range b = km_sparse_b(p, k);
  long next = out.start[k], first = next;
  int own = p->column[p->rank + k];
  work[own] = weight[own];
  out.row[next++] = own;
  for (int i = b.start; i < b.end; ++i) {
    int c = p->column[s->b_store.index[i]];
    work[c] = -s->b_store.value[i] * weight[c];
    out.row[next++] = c;
  }
  qsort(out.row + first, (size_t)(next - first), sizeof *out.row, ascending);
  for (long i = first; i < next; ++i)
    out.value[i] = work[out.row[i]];
  out.start[k + 1] = next;
}

/* The first `count` null vectors, to be factored, where they fill R less than the primary rows; else NULL, as where SPQR isn't
 * installed or memory is out. */
static km_sparse_qr *null_of(const km_partition *p, const double *weight, int count) {
  km_sparse_qr *q = NULL;
  km_error error;
  int entries;
  double *work = KM_NEW(double, (size_t)p->columns + 1), rows = km_sparse_gram_cost(p);
  bool known = !p->sparse->has_rows_only && !p->unrestricted_basis;
  if (work && known && crowd_of_null(p, count, rows, &entries) < rows && km_sparse_current_max_b(p) <= km_max_good_b &&
      !km_sparse_qr_create(p->columns, count, entries, &q, &error))
    for (int k = 0; k < count; ++k)
      fill_null(p, weight, k, work, km_sparse_qr_columns(q));
  km_free(work);
  return q;
}

/* Σ R_ij² over the row space's orthonormal basis. */
static bool dense_shares(const km_partition *p, const double *weight, double *shares) {
  size_t n = (size_t)p->columns;
  double *R = KM_NEW(double, (size_t)p->rank *n + 1);
  if (!R)
    return false;
  km_partition_row_space(p, weight, km_partition_freedom(p), R);
  km_mobility_numbers(R, p->columns, p->rank, shares);
  km_free(R);
  return true;
}

static bool sparse_shares(const km_partition *p, const double *matrix, const double *weight, double *shares) {
  km_normal_equations *normal = km_sparse_create_normal(p);
  const long *order = normal ? km_normal_equations_dissection(normal) : NULL;
  km_sparse_qr *q = rows_of(p, matrix, weight, km_partition_freedom(p), order);
  bool found = q && km_sparse_qr_squared_norms(q, spanned, order != NULL, shares);
  km_sparse_qr_free(q);
  return found;
}

/* Of the null vectors themselves. */
static bool null_shares(const km_partition *p, const double *weight, double *numbers) {
  km_sparse_qr *q = p->sparse ? null_of(p, weight, km_partition_freedom(p)) : NULL;
  bool found = q && km_sparse_qr_squared_norms(q, spanned, false, numbers);
  km_sparse_qr_free(q);
  return found;
}

bool km_partition_mobility_numbers(const km_partition *p, const double *matrix, const double *weight, double *numbers) {
  bool by_null = null_shares(p, weight, numbers);
  if (!by_null && !(p->sparse ? sparse_shares(p, matrix, weight, numbers) : dense_shares(p, weight, numbers)))
    return false;
  for (int c = 0; c < p->columns; ++c) {
    double number = by_null ? numbers[c] : 1.0 - numbers[c];
    numbers[c] = number < rounding || (p->locked && p->locked[c]) ? 0.0 : number;
  }
  return true;
}

/* Takes what the columns of q span, and of the rows the opposite, out of D x. */
static bool reject(km_sparse_qr *q, const km_partition *p, const double *weight, bool by_rows, int count, double *x,
                   double *work) {
  for (int c = 0; c < p->columns; ++c)
    work[c] = weight[c] * x[c];
  for (int k = p->rank + count; k < p->columns && by_rows; ++k)
    work[p->column[k]] = 0.0; /* moved by none of these motions: x keeps it */
  bool done = q && km_sparse_qr_factor(q, spanned) && km_sparse_qr_remove(q, work, 1);
  for (int c = 0; c < p->columns && done; ++c)
    x[c] = by_rows ? x[c] - work[c] / weight[c] : work[c] / weight[c];
  return done;
}

/* The rest of D x is what the rows have of it. What is moved by none of the motions x keeps. */
static bool reject_by_normal(const km_partition *p, const double *matrix, const double *weight, int count, double *x,
                             double *work) {
  km_normal_equations *normal = km_sparse_normal(p, matrix, weight, count);
  double *part = normal ? KM_NEW(double, (size_t)p->columns + 1) : NULL;
  for (int c = 0; c < p->columns; ++c)
    work[c] = weight[c] * x[c];
  bool done = part && km_normal_equations_project(normal, work, part);
  for (int k = 0; k < p->rank + count && done; ++k)
    x[p->column[k]] = part[p->column[k]] / weight[p->column[k]];
  km_free(part);
  return done;
}

bool km_partition_remove_null_space(const km_partition *p, const double *matrix, const double *weight, int count,
                                    double *x, double *work) {
  if (reject_by_normal(p, matrix, weight, count, x, work))
    return true;
  if (p->is_deferred)
    return false;
  km_sparse_qr *null = null_of(p, weight, count), *q = null ? null : rows_of(p, matrix, weight, count, NULL);
  bool done = reject(q, p, weight, !null, count, x, work);
  km_sparse_qr_free(q);
  return done;
}

/* What is left of y, or what was taken out of it. What is no more than rounding makes of 0 is 0. */
static void keep_along(const km_partition *p, bool taken, const double *rest, double *y) {
  static const double grain = 1e-14; /* of its length */
  double least = grain * sqrt(km_sum_of_squares(y, p->columns));
  for (int c = 0; c < p->columns; ++c) {
    double along = taken ? y[c] - rest[c] : rest[c];
    y[c] = fabs(along) <= least || km_sparse_is_locked(p, c) ? 0.0 : along;
  }
}

/* What the rows have of each of Y, by their normal equations. */
static bool along_by_normal(const km_partition *p, const double *matrix, const double *weight, double *Y, int count) {
  size_t n = (size_t)p->columns;
  km_normal_equations *normal = km_sparse_normal(p, matrix, weight, km_partition_freedom(p));
  double *part = normal ? KM_NEW(double, n *(size_t)count + 1) : NULL;
  bool done = part != NULL;
  for (int k = 0; k < count && done; ++k)
    done = km_normal_equations_project(normal, Y + (size_t)k * n, part + (size_t)k * n);
  for (int k = 0; k < count && done; ++k)
    keep_along(p, true, part + (size_t)k * n, Y + (size_t)k * n);
  km_free(part);
  return done;
}

bool km_partition_project_null_space(const km_partition *p, const double *matrix, const double *weight, double *Y,
                                     int count) {
  if (along_by_normal(p, matrix, weight, Y, count))
    return true;
  int freedom = km_partition_freedom(p);
  size_t n = (size_t)p->columns, size = n * (size_t)count;
  km_sparse_qr *null = null_of(p, weight, freedom), *q = null ? null : rows_of(p, matrix, weight, freedom, NULL);
  double *rest = KM_NEW(double, size + 1);
  bool done = q && rest && km_sparse_qr_factor(q, spanned);
  if (done)
    memcpy(rest, Y, size * sizeof *rest);
  done = done && km_sparse_qr_remove(q, rest, count);
  for (int k = 0; k < count && done; ++k)
    keep_along(p, null, rest + (size_t)k * n, Y + (size_t)k * n);
  km_free(rest);
  km_sparse_qr_free(q);
  return done;
}

/* Any solution, less what it has of the null vectors. */
static bool least_by_null(const km_partition *p, const double *weight, int count, const double *rhs, double *x) {
  km_sparse_qr *q = null_of(p, weight, count);
  double *work = KM_NEW(double, (size_t)p->columns + 1);
  if (q && work)
    km_partition_solve(p, rhs, x);
  bool done = work && reject(q, p, weight, false, count, x, work);
  km_free(work);
  km_sparse_qr_free(q);
  return done;
}

static bool least_by_rows(const km_partition *p, const double *matrix, const double *weight, int count,
                          const double *rhs, double *x) {
  km_sparse_qr *q = rows_of(p, matrix, weight, count, NULL);
  double *b = KM_NEW(double, (size_t)p->rank + 1);
  for (int k = 0; k < p->rank && b; ++k)
    b[k] = rhs[p->row[k]];
  bool done = q && b && km_sparse_qr_factor(q, spanned) && km_sparse_qr_minimum_norm(q, b, x);
  for (int c = 0; c < p->columns && done; ++c)
    x[c] /= weight[c];
  km_free(b);
  km_sparse_qr_free(q);
  return done;
}

static bool least_by_normal(const km_partition *p, const double *matrix, const double *weight, int count,
                            const double *rhs, double *x) {
  km_normal_equations *normal = km_sparse_normal(p, matrix, weight, count);
  bool done = normal && km_normal_equations_minimum_norm(normal, rhs, x);
  for (int c = 0; c < p->columns && done; ++c)
    x[c] /= weight[c];
  return done;
}

bool km_partition_minimum_norm(const km_partition *p, const double *matrix, const double *weight, int count,
                               const double *rhs, double *x) {
  if (least_by_normal(p, matrix, weight, count, rhs, x))
    return true;
  return !p->is_deferred &&
         (least_by_null(p, weight, count, rhs, x) || least_by_rows(p, matrix, weight, count, rhs, x));
}

bool km_partition_minimum_norm_reuse(const km_partition *p, const double *weight, int count, const double *rhs,
                                     double *x) {
  return least_by_normal(p, NULL, weight, count, rhs, x);
}
