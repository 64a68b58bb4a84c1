/* Steps without what they have along many motions at once, by sparse Q R of the null vectors. */
#include "partition/orthogonal.h"
#include "partition/partition.h"

#include <math.h>

/* Null vectors are independent by their last rows: [−B; I]. */
static const double spanned = 1e-14;

static int entries_of(const km_partition *p, int count) {
  int entries = count;
  for (size_t i = 0; i < (size_t)count * (size_t)p->rank; ++i)
    entries += p->B[i] != 0.0;
  return entries;
}

/* The rows of D N in the order of the partition's columns, so that they ascend in each column. */
static void fill(const km_partition *p, const double *weight, int count, km_columns out) {
  long next = 0;
  for (int k = 0; k < count; ++k) {
    const double *b = p->B + (size_t)k * (size_t)p->rank;
    for (int i = 0; i < p->rank; ++i)
      if (b[i] != 0.0) {
        out.row[next] = i;
        out.value[next++] = -b[i] * weight[p->column[i]];
      }
    out.row[next] = p->rank + k;
    out.value[next++] = weight[p->column[p->rank + k]];
    out.start[k + 1] = next;
  }
}

bool km_partition_reject_null(const km_partition *p, const double *weight, int count, double *x, double *work) {
  km_orthogonal *q = NULL;
  km_error error;
  if (km_orthogonal_create(p->columns, count, entries_of(p, count), &q, &error))
    return false;
  fill(p, weight, count, km_orthogonal_columns(q));
  for (int k = 0; k < p->columns; ++k)
    work[k] = weight[p->column[k]] * x[p->column[k]];
  bool done = km_orthogonal_factor(q, spanned) && km_orthogonal_reject(q, work);
  for (int k = 0; k < p->columns && done; ++k)
    x[p->column[k]] = work[k] / weight[p->column[k]];
  km_orthogonal_free(q);
  return done;
}
