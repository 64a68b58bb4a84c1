/* Persistent redundancies (theory 7.3): a left null vector w is persistent if more than half of |w|² is its projection
 * on the span of the left null vectors at a neighbouring configuration. */
#include "mobility/persistent_redundancy.h"
#include "base/number/tolerances.h"
#include "base/number/vectors.h"

#include "linalg/sparse/sparse_qr.h"

#include <string.h>

enum { VECTORS_PER_BLOCK = 64 }; /* vectors per block */

typedef struct comparison {
  const km_left_space *a;
  const km_left_null *null, *neighbour;
  km_sparse_qr *neighbour_span; /* QR factor of the neighbour's spanning vectors; NULL: they are orthonormal */
  double *v;                    /* [VECTORS_PER_BLOCK · rows] */
} comparison;

/* Factors the neighbour's spanning vectors as columns of a sparse matrix (QR). */
static km_status factor_neighbour_span(comparison *c, km_error *error) {
  const km_left_null *neighbour = c->neighbour;
  if (neighbour->is_orthonormal || neighbour->spanning_count == 0)
    return KM_OK;
  km_status status =
      km_sparse_qr_create(c->a->rows, neighbour->spanning_count, 6 * neighbour->part_start[neighbour->spanning_count],
                          &c->neighbour_span, error);
  if (status)
    return status;
  km_columns columns = km_sparse_qr_columns(c->neighbour_span);
  long next = 0;
  for (int k = 0; k < neighbour->spanning_count; ++k) {
    for (int i = neighbour->part_start[k]; i < neighbour->part_start[k + 1]; ++i)
      for (int r = 0; r < km_left_rows(c->a, neighbour->part[i].block); ++r, ++next) {
        columns.row[next] = km_left_row(c->a, neighbour->part[i].block) + r;
        columns.value[next] = neighbour->part[i].w[r];
      }
    columns.start[k + 1] = next;
  }
  return km_sparse_qr_factor(c->neighbour_span, km_relative_zero) ? KM_OK : KM_MEMORY;
}

/* Returns the square of the projection of v on the neighbour's vectors of single loops. */
static double square_along_single_loops(const comparison *c, const double *v) {
  double along = 0.0;
  for (int i = 0; i < c->a->sub->loop_count; ++i)
    for (int k = c->neighbour->first[i]; k < c->neighbour->first[i + 1]; ++k) {
      double dot = km_dot(c->neighbour->local + 6 * k, v + 6 * i, 6);
      along += dot * dot;
    }
  return along;
}

/* Returns the square of the projection of v on the neighbour's orthonormal spanning vectors. */
static double square_along_spanning(const comparison *c, const double *v) {
  const km_left_null *neighbour = c->neighbour;
  double along = 0.0;
  for (int k = 0; k < neighbour->spanning_count; ++k) {
    double dot = 0.0;
    for (int i = neighbour->part_start[k]; i < neighbour->part_start[k + 1]; ++i)
      for (int r = 0; r < km_left_rows(c->a, neighbour->part[i].block); ++r)
        dot += neighbour->part[i].w[r] * v[km_left_row(c->a, neighbour->part[i].block) + r];
    along += dot * dot;
  }
  return along;
}

/* Classifies the vectors from `first` on: persistent if more than half of their square is in the neighbour's span,
 * since their frame rotates by a few hundredths only. */
static bool compare_block(const comparison *c, int first, int count, bool *persistent) {
  size_t rows = (size_t)c->a->rows;
  double size[VECTORS_PER_BLOCK], along[VECTORS_PER_BLOCK], span_squares[VECTORS_PER_BLOCK];
  for (int k = 0; k < count; ++k) {
    double *v = c->v + (size_t)k * rows;
    km_left_null_expand(c->a, c->null, first + k, v);
    size[k] = km_dot(v, v, c->a->rows);
    along[k] = square_along_single_loops(c, v) + (c->neighbour_span ? 0.0 : square_along_spanning(c, v));
  }
  if (c->neighbour_span && !km_sparse_qr_projected_squares(c->neighbour_span, c->v, count, span_squares))
    return false;
  for (int k = 0; k < count; ++k)
    persistent[first + k] = along[k] + (c->neighbour_span ? span_squares[k] : 0.0) > 0.5 * size[k];
  return true;
}

static bool compare_all(comparison *c, bool *persistent) {
  int total = km_left_null_count(c->null);
  bool ok = true;
  c->v = KM_NEW(double, (size_t)VECTORS_PER_BLOCK *(size_t)c->a->rows);
  for (int first = 0; first < total && ok; first += VECTORS_PER_BLOCK)
    ok = c->v &&
         compare_block(c, first, total - first < VECTORS_PER_BLOCK ? total - first : VECTORS_PER_BLOCK, persistent);
  km_free(c->v);
  return ok;
}

km_status km_persistent_redundancy_find(const km_left_space *a, const km_left_null *null, const km_left_null *neighbour,
                                        bool *persistent, km_error *error) {
  comparison c = {.a = a, .null = null, .neighbour = neighbour};
  if (km_left_null_count(neighbour) == km_left_null_count(null)) { /* equal numbers: all are persistent */
    memset(persistent, true, (size_t)km_left_null_count(null) * sizeof *persistent);
    return KM_OK;
  }
  km_status status = factor_neighbour_span(&c, error);
  if (!status && !compare_all(&c, persistent))
    status = KM_MEMORY;
  km_sparse_qr_free(c.neighbour_span);
  return status;
}
