/* Projections and minimum-norm solutions with many freedoms (docs/theory.md 3.4, 3.5).
 *
 *   A = J_p D⁻¹:   projection onto the null space  y − Aᵀ (A Aᵀ)⁻¹ A y,    minimum norm  D x = Aᵀ (A Aᵀ)⁻¹ b
 *
 * Methods, in this order: normal equations by sparse Cholesky; sparse QR of the null vectors N where they have less
 * fill-in than the rows; sparse QR of the primary rows. */
#include "base/number/tolerances.h"
#include "linalg/dense/simd_pair.h"
#include "linalg/sparse/normal_equations.h"
#include "linalg/sparse/sparse_lu.h"
#include "linalg/sparse/sparse_qr.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* QR of Aᵀ: the primary rows over the weights, in the order of pivots. Independent columns after the first `count` are
 * omitted. NULL without SPQR or memory. */
static km_sparse_qr *create_row_qr(const km_factor *p, const double *matrix, int count) {
  km_sparse_qr *q = NULL;
  km_error error;
  bool *is_omitted = KM_NEW(bool, (size_t)p->columns + 1);
  if (is_omitted && !km_sparse_qr_create(p->columns, p->rank, p->sparse->start[p->columns], &q, &error)) {
    for (int k = p->rank + count; k < p->columns; ++k)
      is_omitted[p->column[k]] = true;
    for (int k = 0; k < p->rank; ++k)
      km_sparse_fill_row(p->sparse, matrix, p->weight, is_omitted, p->row[k], k, km_sparse_qr_columns(q));
  }
  km_free(is_omitted);
  return q;
}

/* Σ over the rows of N of (number of entries)², for the first `count` null vectors: bound of the fill-in of their QR.
 * The sum stops beyond `most`. */
static double null_gram_cost(const km_factor *p, int count, double most, int *entries) {
  const km_sparse *s = p->sparse;
  int *row_count = KM_NEW(int, (size_t)p->rank + 1);
  double sum = row_count ? count : HUGE_VAL;
  *entries = count;
  for (int k = 0; k < count && sum <= most; ++k) {
    km_entry_range b = km_sparse_b(p, k);
    for (int i = b.start; i < b.end; ++i)
      sum += 2.0 * row_count[s->b_store.index[i]]++ + 1.0; /* (n + 1)² − n² */
    *entries += b.end - b.start;
  }
  km_free(row_count);
  return sum;
}

static int compare_longs(const void *a, const void *b) {
  long x = *(const long *)a, y = *(const long *)b;
  return (x > y) - (x < y);
}

/* Writes D times null vector k to column k, with work[columns]. */
static void write_null_column(const km_factor *p, int k, double *work, km_columns out) {
  const km_sparse *s = p->sparse;
  km_entry_range b = km_sparse_b(p, k);
  long next = out.start[k], first = next;
  int own = p->column[p->rank + k];
  work[own] = p->weight[own];
  out.row[next++] = own;
  for (int i = b.start; i < b.end; ++i) {
    int c = p->column[s->b_store.index[i]];
    work[c] = -s->b_store.value[i] * p->weight[c];
    out.row[next++] = c;
  }
  qsort(out.row + first, (size_t)(next - first), sizeof *out.row, compare_longs);
  for (long i = first; i < next; ++i)
    out.value[i] = work[out.row[i]];
  out.start[k + 1] = next;
}

/* QR of the first `count` null vectors D N, if they have less fill-in than the primary rows; else NULL, as without SPQR
 * or memory. */
static km_sparse_qr *create_null_qr(const km_factor *p, int count) {
  km_sparse_qr *q = NULL;
  km_error error;
  int entries;
  double *work = KM_NEW(double, (size_t)p->columns + 1), rows = km_sparse_gram_cost(p);
  if (work && km_sparse_has_null_vectors(p) && null_gram_cost(p, count, rows, &entries) < rows &&
      km_sparse_current_max_b(p) <= km_max_good_b && !km_sparse_qr_create(p->columns, count, entries, &q, &error))
    for (int k = 0; k < count; ++k)
      write_null_column(p, k, work, km_sparse_qr_columns(q));
  km_free(work);
  return q;
}

/* Σ_k R_jk² of the row space's orthonormal basis R, dense. */
static bool dense_row_norms(const km_factor *p, double *shares) {
  size_t n = (size_t)p->columns;
  double *R = KM_NEW(double, (size_t)p->rank *n + 1);
  if (!R)
    return false;
  km_factor_write_row_space(p, km_factor_freedom(p), R);
  km_mobility_numbers(R, p->columns, p->rank, shares);
  km_free(R);
  return true;
}

/* Σ_k R_jk² of the row space by sparse QR of the primary rows. */
static bool sparse_row_norms(const km_factor *p, const double *matrix, double *shares) {
  km_sparse_qr *q = create_row_qr(p, matrix, km_factor_freedom(p));
  bool found = q && km_sparse_qr_squared_norms(q, km_sum_rounding, shares);
  km_sparse_qr_free(q);
  return found;
}

/* Mobility numbers Σ_k Z_jk² by sparse QR of the null vectors. */
static bool sparse_null_norms(const km_factor *p, double *numbers) {
  km_sparse_qr *q = p->sparse ? create_null_qr(p, km_factor_freedom(p)) : NULL;
  bool found = q && km_sparse_qr_squared_norms(q, km_sum_rounding, numbers);
  km_sparse_qr_free(q);
  return found;
}

/* m_j by squared row norms of the null vectors' or rows' orthonormal basis. */
bool km_factor_mobility_numbers(const km_factor *p, const double *matrix, double *numbers) {
  bool uses_null_vectors = sparse_null_norms(p, numbers);
  if (!uses_null_vectors && !(p->sparse ? sparse_row_norms(p, matrix, numbers) : dense_row_norms(p, numbers)))
    return false;
  for (int c = 0; c < p->columns; ++c) {
    double m_j = uses_null_vectors ? numbers[c] : 1.0 - numbers[c];
    numbers[c] = m_j < 10.0 * km_sum_rounding || km_factor_is_locked(p, c) ? 0.0 : m_j;
  }
  return true;
}

/* QR of the first `count` null vectors or, if that has more fill-in, of the rows. */
static km_sparse_qr *create_qr(const km_factor *p, const double *matrix, int count, bool *is_null) {
  km_sparse_qr *q = create_null_qr(p, count);
  *is_null = q != NULL;
  q = q ? q : create_row_qr(p, matrix, count);
  if (q && km_sparse_qr_factor(q, km_sum_rounding))
    return q;
  km_sparse_qr_free(q);
  return NULL;
}

/* Row-space parts of D y for each of the `count` vectors D y of Y: by normal equations, else by sparse QR. The motions
 * are those of the first `free` independent columns; entries in the other ones are undefined. */
static bool find_row_parts(const km_factor *p, const double *matrix, int free, const double *Y, int count,
                           double *parts) {
  size_t n = (size_t)p->columns, size = n * (size_t)count;
  km_normal_equations *normal = km_sparse_normal(p, matrix, free);
  bool is_ok = normal != NULL, is_null;
  for (int k = 0; k < count && is_ok; ++k)
    is_ok = km_normal_equations_project(normal, Y + (size_t)k * n, parts + (size_t)k * n);
  if (is_ok)
    return true;
  km_sparse_qr *q = create_qr(p, matrix, free, &is_null);
  memcpy(parts, Y, size * sizeof *parts);
  is_ok = q && km_sparse_qr_remove(q, parts, count);
  for (size_t i = 0; i < size && is_ok && !is_null; ++i)
    parts[i] = Y[i] - parts[i];
  km_sparse_qr_free(q);
  return is_ok;
}

/* D x becomes its row-space part. Coordinates that these motions do not move keep their entries of x. */
bool km_sparse_remove_null_space(const km_factor *p, const double *matrix, int count, double *x, double *work) {
  double *part = KM_NEW(double, (size_t)p->columns + 1);
  for (int c = 0; c < p->columns; ++c)
    work[c] = p->weight[c] * x[c];
  bool is_ok = part && find_row_parts(p, matrix, count, work, 1, part);
  for (int k = 0; k < p->rank + count && is_ok; ++k)
    x[p->column[k]] = part[p->column[k]] / p->weight[p->column[k]];
  km_free(part);
  return is_ok;
}

/* y minus its row-space part. Entries of rounding size become 0. */
bool km_factor_project_null_space(const km_factor *p, const double *matrix, double *Y, int count) {
  size_t n = (size_t)p->columns;
  double *parts = KM_NEW(double, n *(size_t)count + 1);
  bool is_ok = parts && find_row_parts(p, matrix, km_factor_freedom(p), Y, count, parts);
  for (int k = 0; k < count && is_ok; ++k) {
    double *y = Y + (size_t)k * n, threshold = km_sum_rounding * sqrt(km_pair_dot(y, y, p->columns));
    for (int c = 0; c < p->columns; ++c) {
      double value = y[c] - parts[(size_t)k * n + (size_t)c];
      y[c] = fabs(value) <= threshold || km_factor_is_locked(p, c) ? 0.0 : value;
    }
  }
  km_free(parts);
  return is_ok;
}

/* Minimum-norm solution D x by sparse QR: of a particular solution by the null vectors, or of the rows. */
static bool minimum_norm_by_qr(const km_factor *p, const double *matrix, int count, const double *rhs, double *x) {
  bool is_null;
  km_sparse_qr *q = create_qr(p, matrix, count, &is_null);
  double *b = KM_NEW(double, (size_t)p->rank + 1);
  for (int k = 0; k < p->rank && b; ++k)
    b[k] = rhs[p->row[k]];
  bool is_ok = q && b;
  if (is_ok && is_null)
    km_factor_solve(p, rhs, x);
  for (int c = 0; c < p->columns && is_ok && is_null; ++c)
    x[c] *= p->weight[c];
  is_ok = is_ok && (is_null ? km_sparse_qr_remove(q, x, 1) : km_sparse_qr_minimum_norm(q, b, x));
  km_free(b);
  km_sparse_qr_free(q);
  return is_ok;
}

/* Minimum-norm solution by normal equations, else by QR. */
bool km_sparse_minimum_norm(const km_factor *p, const double *matrix, int count, const double *rhs, double *x) {
  km_normal_equations *normal = km_sparse_normal(p, matrix, count);
  bool is_ok =
      (normal && km_normal_equations_minimum_norm(normal, rhs, x)) || minimum_norm_by_qr(p, matrix, count, rhs, x);
  for (int c = 0; c < p->columns && is_ok; ++c)
    x[c] /= p->weight[c];
  return is_ok;
}

bool km_factor_avoids_basis(const km_factor *p) {
  return p->sparse && km_factor_freedom(p) > KM_MANY_VECTORS;
}

bool km_factor_numbers_avoid_basis(const km_factor *p) {
  int freedom = km_factor_freedom(p);
  return freedom > KM_MANY_VECTORS && (p->sparse || p->rank < freedom);
}

/* True if row equations are cheaper than a basis of the null space of `count` vectors and than one of the row space. */
static bool uses_row_equations(const km_factor *p, int count) {
  return p->sparse && (p->rank < count ? p->rank : count) > KM_MANY_VECTORS;
}

/* Projection of D x onto the `count` orthonormal vectors of Y, into sum[columns]. */
static void project_onto_basis(const km_factor *p, const double *Y, int count, const double *x, double *sum) {
  memset(sum, 0, (size_t)p->columns * sizeof *sum);
  for (int k = 0; k < count; ++k) {
    const double *y = Y + (size_t)k * (size_t)p->columns;
    double dot = 0.0;
    for (int j = 0; j < p->columns; ++j)
      dot += y[j] * p->weight[j] * x[j];
    for (int j = 0; j < p->columns; ++j)
      sum[j] += dot * y[j];
  }
}

/* Uses row equations; else D x minus its projection onto the null space Z, or its projection onto the row space R:
 * whichever has fewer vectors. */
void km_factor_remove_null_space(km_factor *p, const double *matrix, int count, double *x) {
  if (count <= 0 || !km_factor_has_null_vectors(p))
    return;
  if (uses_row_equations(p, count) && km_sparse_remove_null_space(p, matrix, count, x, p->projection)) {
    p->Z_count = 0;
    return;
  }
  bool uses_row_space = p->rank < count;
  const double *Y = uses_row_space ? km_factor_row_space(p, count) : km_factor_null_space(p, count);
  if (!Y)
    return;
  project_onto_basis(p, Y, uses_row_space ? p->rank : count, x, p->projection);
  for (int k = 0; k < p->rank + count; ++k) {
    int c = p->column[k];
    double part = p->projection[c] / p->weight[c];
    x[c] = uses_row_space ? part : x[c] - part;
  }
}

/* With many freedoms other solutions can be so long that projecting them leaves rounding, so the row equations come
 * first. */
void km_factor_minimum_norm(km_factor *p, const double *matrix, int count, const double *rhs, double *x) {
  if ((uses_row_equations(p, count) || !km_factor_has_null_vectors(p)) &&
      km_sparse_minimum_norm(p, matrix, count, rhs, x))
    return;
  km_factor_solve(p, rhs, x);
  km_factor_remove_null_space(p, matrix, count, x);
}
