/* What many motions have of a step or of a coordinate, from the row space, to which all of them are at right angles: of a
 * matrix with few entries by sparse Q R of its primary rows, which have fewer entries than the motions. */
#include "partition/orthogonal.h"
#include "partition/sparse.h"

/* Primary rows are independent: each has a pivot. */
static const double spanned = 1e-14;
/* What is left of 1 by taking squares out of it keeps that much of rounding. */
static const double rounding = 1e-13;

/* The primary rows over the weights, as columns; those of the matrix that `left_out` names have no entries. */
static void fill(const km_partition *p, const double *matrix, const double *weight, const bool *left_out,
                 km_columns out) {
  const km_sparse *s = p->sparse;
  long next = 0;
  for (int k = 0; k < p->rank; ++k) {
    for (int i = s->row_start[p->row[k]]; i < s->row_start[p->row[k] + 1]; ++i) {
      const km_row_entry *at = &s->by_row[i];
      if (matrix[at->entry] == 0.0 || left_out[at->column])
        continue;
      out.row[next] = at->column;
      out.value[next++] = matrix[at->entry] / weight[at->column];
    }
    out.start[k + 1] = next;
  }
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
    fill(p, matrix, weight, left_out, km_orthogonal_columns(q));
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
