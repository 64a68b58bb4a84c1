/* Normal equations of the primary rows, and dependent rows by a sparse QR (docs/theory.md 3.6). */
#include "base/number/tolerances.h"
#include "linalg/sparse/normal_equations.h"
#include "linalg/sparse/sparse_lu.h"
#include "linalg/sparse/sparse_qr.h"

void km_sparse_fill_row(const km_sparse *s, const double *matrix, const double *weight, const bool *is_omitted, int row,
                        int k, km_columns out) {
  long next = out.start[k];
  for (int i = s->row_start[row]; i < s->row_start[row + 1]; ++i) {
    const km_row_entry *at = &s->by_row[i];
    if (matrix[at->entry] == 0.0 || is_omitted[at->column])
      continue;
    out.row[next] = at->column;
    out.value[next++] = weight ? matrix[at->entry] / weight[at->column] : matrix[at->entry];
  }
  out.start[k + 1] = next;
}

double km_sparse_gram_cost(const km_factor *p) {
  const km_sparse *s = p->sparse;
  double sum = 0.0;
  for (int c = 0; c < p->columns; ++c) {
    double count = 0.0;
    for (int i = s->start[c]; i < s->start[c + 1]; ++i)
      count += s->step_of[s->row[i]] >= 0;
    sum += count * count;
  }
  return sum;
}

/* Σ over the columns of (entries)²: bound of the entries of J Jᵀ. */
double km_sparse_full_gram_cost(const km_factor *p) {
  const km_sparse *s = p->sparse;
  double sum = 0.0;
  for (int c = 0; c < p->columns; ++c)
    sum += (double)(s->start[c + 1] - s->start[c]) * (s->start[c + 1] - s->start[c]);
  return sum;
}

bool km_sparse_gram_is_dense(const km_factor *p) {
  return km_sparse_full_gram_cost(p) > km_significant_ratio * p->sparse->start[p->columns];
}

/* Creates the normal equations of the pattern once. */
static km_normal_equations *create_normal(const km_factor *p) {
  const km_sparse *s = p->sparse;
  if (!s->normal || km_sparse_gram_is_dense(p))
    return NULL;
  if (!*s->normal)
    *s->normal = km_normal_equations_create(p->rows, p->columns, s->start, s->row);
  return *s->normal;
}

/* Factors the normal equations of the primary rows. */
km_normal_equations *km_sparse_normal(const km_factor *p, const double *matrix, int count) {
  km_normal_equations *normal = create_normal(p);
  if (!normal)
    return NULL;
  bool *rows = KM_NEW(bool, (size_t)p->rows + 1), *columns = KM_NEW(bool, (size_t)p->columns + 1);
  for (int k = 0; k < p->rank && rows; ++k)
    rows[p->row[k]] = true;
  for (int k = 0; k < p->rank + count && columns; ++k)
    columns[p->column[k]] = true;
  bool is_ok = rows && columns && km_normal_equations_factor(normal, matrix, p->weight, rows, columns);
  km_free(rows);
  km_free(columns);
  return is_ok ? normal : NULL;
}

/* Dependent rows by sparse QR of Jᵀ. */
bool km_sparse_find_dependent_rows(km_factor *p, const double *matrix, const bool *forced, double threshold) {
  km_sparse_qr *q = NULL;
  km_error error;
  int rank = -1, *independent = KM_NEW(int, (size_t)p->rows + 1);
  bool *is_omitted = KM_NEW(bool, (size_t)p->columns + 1);
  if (independent && is_omitted &&
      !km_sparse_qr_create(p->columns, p->rows, p->sparse->start[p->columns], &q, &error)) {
    for (int c = 0; c < p->columns; ++c)
      is_omitted[c] = km_factor_is_locked(p, c) || (p->options.forced_never_pivot && forced && forced[c]);
    for (int r = 0; r < p->rows; ++r)
      km_sparse_fill_row(p->sparse, matrix, NULL, is_omitted, r, r, km_sparse_qr_columns(q));
    rank = km_sparse_qr_independent_columns(q, threshold, independent);
  }
  for (int r = 0; r < p->rows && rank >= 0; ++r)
    p->sparse->is_excluded_row[r] = true;
  for (int k = 0; k < rank; ++k)
    p->sparse->is_excluded_row[independent[k]] = false;
  km_sparse_qr_free(q);
  km_free(is_omitted);
  km_free(independent);
  return rank >= 0 && rank < p->rows;
}
