/* What many motions have of a step or of a coordinate, from the row space, to which all of them are at right angles: of a
 * matrix with few entries by sparse Q R of its primary rows, which have fewer entries than the motions. */
#include "partition/orthogonal.h"
#include "partition/sparse.h"

/* Primary rows are independent: each has a pivot. */
static const double spanned = 1e-14;
/* What is left of 1 by taking squares out of it keeps that much of rounding. */
static const double rounding = 1e-13;

/* Row `row` of the matrix over the weights, NULL: over 1, becomes column k; columns of the matrix that `left_out` names have no
 * entries. */
static void fill_row(const km_sparse *s, const double *matrix, const double *weight, const bool *left_out, int row,
                     int k, km_columns out) {
  long next = out.start[k];
  for (int i = s->row_start[row]; i < s->row_start[row + 1]; ++i) {
    const km_row_entry *at = &s->by_row[i];
    if (matrix[at->entry] == 0.0 || left_out[at->column])
      continue;
    out.row[next] = at->column;
    out.value[next++] = weight ? matrix[at->entry] / weight[at->column] : matrix[at->entry];
  }
  out.start[k + 1] = next;
}

/* The rows, to be factored; the independent columns behind the first `count` are left out. NULL where SPQR isn't installed or
 * memory is out. */
static km_orthogonal *rows_of(const km_partition *p, const double *matrix, const double *weight, int count) {
  km_orthogonal *q = NULL;
  km_error error;
  bool *left_out = KM_NEW(bool, (size_t)p->columns + 1);
  if (left_out && !km_orthogonal_create(p->columns, p->rank, p->sparse->start[p->columns], &q, &error)) {
    for (int k = p->rank + count; k < p->columns; ++k)
      left_out[p->column[k]] = true;
    for (int k = 0; k < p->rank; ++k)
      fill_row(p->sparse, matrix, weight, left_out, p->row[k], k, km_orthogonal_columns(q));
  }
  km_free(left_out);
  return q;
}

/* Σ R_ij² over the row space's orthonormal basis. */
static bool dense_shares(const km_partition *p, const double *weight, double *shares) {
  size_t n = (size_t)p->columns;
  double *R = KM_NEW(double, (size_t)p->rank *n + 1);
  if (!R)
    return false;
  km_partition_rows(p, weight, km_partition_freedom(p), R);
  km_mobility_numbers(R, p->columns, p->rank, shares);
  km_free(R);
  return true;
}

static bool sparse_shares(const km_partition *p, const double *matrix, const double *weight, double *shares) {
  km_orthogonal *q = rows_of(p, matrix, weight, km_partition_freedom(p));
  bool found = q && km_orthogonal_shares(q, spanned, shares);
  km_orthogonal_free(q);
  return found;
}

bool km_partition_numbers(const km_partition *p, const double *matrix, const double *weight, double *numbers) {
  if (!(p->sparse ? sparse_shares(p, matrix, weight, numbers) : dense_shares(p, weight, numbers)))
    return false;
  for (int c = 0; c < p->columns; ++c) {
    double number = 1.0 - numbers[c];
    numbers[c] = number < rounding || (p->locked && p->locked[c]) ? 0.0 : number;
  }
  return true;
}

bool km_partition_reject_null(const km_partition *p, const double *matrix, const double *weight, int count, double *x,
                              double *work) {
  km_orthogonal *q = rows_of(p, matrix, weight, count);
  for (int c = 0; c < p->columns; ++c)
    work[c] = weight[c] * x[c];
  for (int k = p->rank + count; k < p->columns; ++k)
    work[p->column[k]] = 0.0; /* moved by none of these motions: x keeps it */
  bool done = q && km_orthogonal_factor(q, spanned) && km_orthogonal_reject(q, work);
  for (int c = 0; c < p->columns && done; ++c)
    x[c] -= work[c] / weight[c];
  km_orthogonal_free(q);
  return done;
}

bool km_partition_least(const km_partition *p, const double *matrix, const double *weight, int count, const double *rhs,
                        double *x) {
  km_orthogonal *q = rows_of(p, matrix, weight, count);
  double *b = KM_NEW(double, (size_t)p->rank + 1);
  for (int k = 0; k < p->rank && b; ++k)
    b[k] = rhs[p->row[k]];
  bool done = q && b && km_orthogonal_factor(q, spanned) && km_orthogonal_least(q, b, x);
  for (int c = 0; c < p->columns && done; ++c)
    x[c] /= weight[c];
  km_free(b);
  km_orthogonal_free(q);
  return done;
}

bool km_sparse_spare_rows(km_partition *p, const double *matrix, const bool *forced, double threshold) {
  km_orthogonal *q = NULL;
  km_error error;
  int rank = -1, *list = KM_NEW(int, (size_t)p->rows + 1);
  bool *left_out = KM_NEW(bool, (size_t)p->columns + 1);
  if (list && left_out && !km_orthogonal_create(p->columns, p->rows, p->sparse->start[p->columns], &q, &error)) {
    for (int c = 0; c < p->columns; ++c)
      left_out[c] = km_sparse_is_locked(p, c) || (p->held && forced && forced[c]);
    for (int r = 0; r < p->rows; ++r)
      fill_row(p->sparse, matrix, NULL, left_out, r, r, km_orthogonal_columns(q));
    rank = km_orthogonal_independent(q, threshold, list);
  }
  for (int r = 0; r < p->rows && rank >= 0; ++r)
    p->sparse->spare[r] = true;
  for (int k = 0; k < rank; ++k)
    p->sparse->spare[list[k]] = false;
  km_orthogonal_free(q);
  km_free(left_out);
  km_free(list);
  return rank >= 0 && rank < p->rows;
}
