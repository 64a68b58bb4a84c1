/* What many motions have of a step or of a coordinate: of a matrix with few entries by sparse Q R of its primary rows, to which
 * all motions are at right angles, or of the null vectors, whichever fills R less. */
#include "partition/normal.h"
#include "partition/orthogonal.h"
#include "partition/pair.h"
#include "partition/sparse.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

/* The rows, to be factored, in the order of all rows that is given; NULL: in that of their pivots. The independent columns behind the
 * first `count` are left out. NULL where SPQR isn't installed or memory is out. */
static km_orthogonal *rows_of(const km_partition *p, const double *matrix, const double *weight, int count,
                              const long *order) {
  km_orthogonal *q = NULL;
  km_error error;
  bool *left_out = KM_NEW(bool, (size_t)p->columns + 1);
  if (left_out && !km_orthogonal_create(p->columns, p->rank, p->sparse->start[p->columns], &q, &error)) {
    for (int k = p->rank + count; k < p->columns; ++k)
      left_out[p->column[k]] = true;
    for (int i = 0, k = 0; i < p->rows && k < p->rank; ++i) {
      int row = order ? (int)order[i] : p->row[i];
      if (p->sparse->step_of[row] >= 0)
        fill_row(p->sparse, matrix, weight, left_out, row, k++, km_orthogonal_columns(q));
    }
  }
  km_free(left_out);
  return q;
}

bool km_partition_may_wait(const km_partition *p) {
  return p->sparse && p->sparse->normal && !km_sparse_is_crowded(p) && km_normal_is_installed();
}

/* NULL where normal equations aren't kept, or would be full. */
static km_normal *need_normal(const km_partition *p) {
  const km_sparse *s = p->sparse;
  if (!km_partition_may_wait(p))
    return NULL;
  if (!*s->normal)
    *s->normal = km_normal_create(p->rows, p->columns, s->start, s->row);
  return *s->normal;
}

/* The rows by their normal equations, those of the matrix that was factored last where none is given; NULL where these aren't kept, or
 * would be full, or don't tell. */
static km_normal *normal_of(const km_partition *p, const double *matrix, const double *weight, int count) {
  km_normal *normal = need_normal(p);
  if (!normal)
    return NULL;
  bool *rows = KM_NEW(bool, (size_t)p->rows + 1), *columns = KM_NEW(bool, (size_t)p->columns + 1);
  for (int k = 0; k < p->rank && rows; ++k)
    rows[p->row[k]] = true;
  for (int k = 0; k < p->rank + count && columns; ++k)
    columns[p->column[k]] = true;
  bool good = rows && columns &&
              (matrix ? km_normal_factor(normal, matrix, weight, rows, columns) : km_normal_has(normal, rows, columns));
  km_free(rows);
  km_free(columns);
  return good ? normal : NULL;
}

/* Columns that may be pivots first, then the forced and the locked ones; returns how many may be. */
static int arrange_columns(const km_partition *p, const bool *forced) {
  int next = 0, most = 0;
  for (int group = 0; group < 3; ++group) {
    for (int c = 0; c < p->columns; ++c)
      if ((km_sparse_is_locked(p, c) ? 2 : km_sparse_is_given(p, forced, c)) == group)
        p->column[next++] = c;
    most = group == 0 ? next : most;
  }
  return most;
}

/* How far from the primary rows, which the normal equations have, those that aren't primary are, over the largest entry: about the
 * length of what is left of a sum of them all, each with a factor as if by chance. */
static double distance_of_others(const km_partition *p, km_normal *normal, const double *matrix, int used) {
  const km_sparse *s = p->sparse;
  size_t n = (size_t)p->columns;
  double *sum = KM_NEW(double, n + 1), *part = KM_NEW(double, n + 1), largest = 0.0, square = 0.0;
  for (int k = 0; k < used && sum; ++k) {
    int c = p->column[k];
    for (int i = s->start[c]; i < s->start[c + 1]; ++i) {
      double entry = matrix[i] / s->weight[c];
      largest = fmax(largest, fabs(entry));
      sum[c] += s->step_of[s->row[i]] < 0 ? km_sparse_weight(s->row[i], 0) * entry : 0.0;
    }
  }
  bool found = sum && part && km_normal_part(normal, sum, part);
  for (size_t c = 0; c < n && found; ++c)
    square += (sum[c] - part[c]) * (sum[c] - part[c]);
  km_free(sum);
  km_free(part);
  return found ? sqrt(square) / largest : HUGE_VAL;
}

/* The rows that are tried as primary ones. */
static void list_rows(km_partition *p, bool kept) {
  const km_sparse *s = p->sparse;
  for (int r = 0; r < p->rows; ++r) {
    s->step_of[r] = -1;
    p->row[r] = kept ? p->row[r] : r;
  }
  p->rank = kept ? p->rank : p->rows;
  for (int k = 0; k < p->rank; ++k)
    s->step_of[p->row[k]] = k;
}

bool km_sparse_rows_stand(km_partition *p, const double *matrix, const bool *forced, double tolerance) {
  km_sparse *s = p->sparse;
  const bool kept = p->kept_rows > 0.0;
  const double least = kept ? p->kept_rows : tolerance;
  int most = s->normal ? arrange_columns(p, forced) : 0;
  if (most < (kept ? p->rank : p->rows))
    return false;
  list_rows(p, kept);
  km_normal *normal = normal_of(p, matrix, s->weight, most - p->rank);
  double smallest = normal ? km_normal_smallest(normal) : 0.0;
  if (!(smallest > least))
    return false;
  double left = p->rank < p->rows ? distance_of_others(p, normal, matrix, most) : 0.0;
  if (!(left <= tolerance))
    return false;
  p->first_pivot = p->scale;
  p->last_pivot = p->smallest_pivot = smallest * p->scale;
  p->first_dropped = left * p->scale;
  p->forced_dependent = false;
  p->rows_stayed = kept;
  for (int k = 0; k < p->rank; ++k)
    p->inverse[k] = 1.0 / p->last_pivot;
  s->singles = s->zero_count = 0;
  memset(s->upper, 0, (size_t)p->columns * sizeof *s->upper);
  memset(s->lower, 0, (size_t)p->columns * sizeof *s->lower);
  return true;
}

/* Σ over all rows of N, of the first `count` null vectors, of the squared number of entries; it ends beyond `most`. */
static double crowd_of_null(const km_partition *p, int count, double most, int *entries) {
  const km_sparse *s = p->sparse;
  int *met = KM_NEW(int, (size_t)p->rank + 1);
  double sum = met ? count : HUGE_VAL;
  *entries = count;
  for (int k = 0; k < count && sum <= most; ++k) {
    km_run b = km_sparse_b(p, k);
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
  km_run b = km_sparse_b(p, k);
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
static km_orthogonal *null_of(const km_partition *p, const double *weight, int count) {
  km_orthogonal *q = NULL;
  km_error error;
  int entries;
  double *work = KM_NEW(double, (size_t)p->columns + 1), rows = km_sparse_crowd(p);
  bool known = !p->sparse->by_rows && !p->any_independent;
  if (work && known && crowd_of_null(p, count, rows, &entries) < rows && km_sparse_size_of_b(p) <= km_largest_good_b &&
      !km_orthogonal_create(p->columns, count, entries, &q, &error))
    for (int k = 0; k < count; ++k)
      fill_null(p, weight, k, work, km_orthogonal_columns(q));
  km_free(work);
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
  km_normal *normal = need_normal(p);
  const long *order = normal ? km_normal_dissection(normal) : NULL;
  km_orthogonal *q = rows_of(p, matrix, weight, km_partition_freedom(p), order);
  bool found = q && km_orthogonal_shares(q, spanned, order != NULL, shares);
  km_orthogonal_free(q);
  return found;
}

/* Of the null vectors themselves. */
static bool null_shares(const km_partition *p, const double *weight, double *numbers) {
  km_orthogonal *q = p->sparse ? null_of(p, weight, km_partition_freedom(p)) : NULL;
  bool found = q && km_orthogonal_shares(q, spanned, false, numbers);
  km_orthogonal_free(q);
  return found;
}

bool km_partition_numbers(const km_partition *p, const double *matrix, const double *weight, double *numbers) {
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
static bool reject(km_orthogonal *q, const km_partition *p, const double *weight, bool by_rows, int count, double *x,
                   double *work) {
  for (int c = 0; c < p->columns; ++c)
    work[c] = weight[c] * x[c];
  for (int k = p->rank + count; k < p->columns && by_rows; ++k)
    work[p->column[k]] = 0.0; /* moved by none of these motions: x keeps it */
  bool done = q && km_orthogonal_factor(q, spanned) && km_orthogonal_reject(q, work, 1);
  for (int c = 0; c < p->columns && done; ++c)
    x[c] = by_rows ? x[c] - work[c] / weight[c] : work[c] / weight[c];
  return done;
}

/* The rest of D x is what the rows have of it. What is moved by none of the motions x keeps. */
static bool reject_by_normal(const km_partition *p, const double *matrix, const double *weight, int count, double *x,
                             double *work) {
  km_normal *normal = normal_of(p, matrix, weight, count);
  double *part = normal ? KM_NEW(double, (size_t)p->columns + 1) : NULL;
  for (int c = 0; c < p->columns; ++c)
    work[c] = weight[c] * x[c];
  bool done = part && km_normal_part(normal, work, part);
  for (int k = 0; k < p->rank + count && done; ++k)
    x[p->column[k]] = part[p->column[k]] / weight[p->column[k]];
  km_free(part);
  return done;
}

bool km_partition_reject_null(const km_partition *p, const double *matrix, const double *weight, int count, double *x,
                              double *work) {
  if (reject_by_normal(p, matrix, weight, count, x, work))
    return true;
  if (p->waits)
    return false;
  km_orthogonal *null = null_of(p, weight, count), *q = null ? null : rows_of(p, matrix, weight, count, NULL);
  bool done = reject(q, p, weight, !null, count, x, work);
  km_orthogonal_free(q);
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
  km_normal *normal = normal_of(p, matrix, weight, km_partition_freedom(p));
  double *part = normal ? KM_NEW(double, n *(size_t)count + 1) : NULL;
  bool done = part != NULL;
  for (int k = 0; k < count && done; ++k)
    done = km_normal_part(normal, Y + (size_t)k * n, part + (size_t)k * n);
  for (int k = 0; k < count && done; ++k)
    keep_along(p, true, part + (size_t)k * n, Y + (size_t)k * n);
  km_free(part);
  return done;
}

bool km_partition_along_null(const km_partition *p, const double *matrix, const double *weight, double *Y, int count) {
  if (along_by_normal(p, matrix, weight, Y, count))
    return true;
  int freedom = km_partition_freedom(p);
  size_t n = (size_t)p->columns, size = n * (size_t)count;
  km_orthogonal *null = null_of(p, weight, freedom), *q = null ? null : rows_of(p, matrix, weight, freedom, NULL);
  double *rest = KM_NEW(double, size + 1);
  bool done = q && rest && km_orthogonal_factor(q, spanned);
  if (done)
    memcpy(rest, Y, size * sizeof *rest);
  done = done && km_orthogonal_reject(q, rest, count);
  for (int k = 0; k < count && done; ++k)
    keep_along(p, null, rest + (size_t)k * n, Y + (size_t)k * n);
  km_free(rest);
  km_orthogonal_free(q);
  return done;
}

/* Any solution, less what it has of the null vectors. */
static bool least_by_null(const km_partition *p, const double *weight, int count, const double *rhs, double *x) {
  km_orthogonal *q = null_of(p, weight, count);
  double *work = KM_NEW(double, (size_t)p->columns + 1);
  if (q && work)
    km_partition_solve(p, rhs, x);
  bool done = work && reject(q, p, weight, false, count, x, work);
  km_free(work);
  km_orthogonal_free(q);
  return done;
}

static bool least_by_rows(const km_partition *p, const double *matrix, const double *weight, int count,
                          const double *rhs, double *x) {
  km_orthogonal *q = rows_of(p, matrix, weight, count, NULL);
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

static bool least_by_normal(const km_partition *p, const double *matrix, const double *weight, int count,
                            const double *rhs, double *x) {
  km_normal *normal = normal_of(p, matrix, weight, count);
  bool done = normal && km_normal_least(normal, rhs, x);
  for (int c = 0; c < p->columns && done; ++c)
    x[c] /= weight[c];
  return done;
}

bool km_partition_least(const km_partition *p, const double *matrix, const double *weight, int count, const double *rhs,
                        double *x) {
  if (least_by_normal(p, matrix, weight, count, rhs, x))
    return true;
  return !p->waits && (least_by_null(p, weight, count, rhs, x) || least_by_rows(p, matrix, weight, count, rhs, x));
}

bool km_partition_least_again(const km_partition *p, const double *weight, int count, const double *rhs, double *x) {
  return least_by_normal(p, NULL, weight, count, rhs, x);
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
