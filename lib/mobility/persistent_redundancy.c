/* Redundant constraints that last: what the left null vectors of a pose have along those of a pose nearby. */
#include "mobility/persistent_redundancy.h"

#include "linalg/sparse/sparse_qr.h"

#include <string.h>

enum { BLOCK = 64 };                /* vectors that are looked at together */
static const double spanned = 1e-9; /* of the nearby vectors: unit vectors, all independent */

typedef struct comparison {
  const km_left_space *a;
  const km_left_null *null, *nearby;
  const double *local;
  km_sparse_qr *span; /* of the nearby vectors of several loops, where they aren't orthonormal; NULL: they are */
  double *v;          /* [BLOCK · rows] */
} comparison;

static void place_parts(const comparison *c, const km_left_null *null, int n, double *v) {
  for (int i = null->part_start[n]; i < null->part_start[n + 1]; ++i)
    memcpy(v + km_left_row(c->a, null->part[i].place), null->part[i].w,
           (size_t)km_left_rows(c->a, null->part[i].place) * sizeof *v);
}

/* The nearby vectors of several loops as columns of a matrix, factored. */
static km_status find_span(comparison *c, km_error *error) {
  const km_left_null *near = c->nearby;
  if (near->orthonormal || near->whole_count == 0)
    return KM_OK;
  km_status status =
      km_sparse_qr_create(c->a->rows, near->whole_count, 6 * near->part_start[near->whole_count], &c->span, error);
  if (status)
    return status;
  km_columns columns = km_sparse_qr_columns(c->span);
  long next = 0;
  for (int k = 0; k < near->whole_count; ++k) {
    for (int i = near->part_start[k]; i < near->part_start[k + 1]; ++i)
      for (int r = 0; r < km_left_rows(c->a, near->part[i].place); ++r, ++next) {
        columns.row[next] = km_left_row(c->a, near->part[i].place) + r;
        columns.value[next] = near->part[i].w[r];
      }
    columns.start[k + 1] = next;
  }
  return km_sparse_qr_factor(c->span, spanned) ? KM_OK : KM_MEMORY;
}

/* Vector k in all rows: those of single loops come first. */
static void make_vector(const comparison *c, int k, double *v) {
  memset(v, 0, (size_t)c->a->rows * sizeof *v);
  if (k >= c->null->local_count) {
    place_parts(c, c->null, k - c->null->local_count, v);
    return;
  }
  int loop = 0;
  while (c->null->first[loop + 1] <= k)
    ++loop;
  memcpy(v + 6 * loop, c->local + 6 * k, 6 * sizeof *v);
}

/* The square of what v has along the nearby vectors of single loops. */
static double along_local(const comparison *c, const double *v) {
  double along = 0.0;
  for (int i = 0; i < c->a->sub->loop_count; ++i)
    for (int k = c->nearby->first[i]; k < c->nearby->first[i + 1]; ++k) {
      double dot = 0.0;
      for (int r = 0; r < 6; ++r)
        dot += c->nearby->local[6 * k + r] * v[6 * i + r];
      along += dot * dot;
    }
  return along;
}

/* The same along those of several loops, which are orthonormal. */
static double along_whole(const comparison *c, const double *v) {
  const km_left_null *near = c->nearby;
  double along = 0.0;
  for (int k = 0; k < near->whole_count; ++k) {
    double dot = 0.0;
    for (int i = near->part_start[k]; i < near->part_start[k + 1]; ++i)
      for (int r = 0; r < km_left_rows(c->a, near->part[i].place); ++r)
        dot += near->part[i].w[r] * v[km_left_row(c->a, near->part[i].place) + r];
    along += dot * dot;
  }
  return along;
}

static double square(const double *v, int count) {
  double sum = 0.0;
  for (int r = 0; r < count; ++r)
    sum += v[r] * v[r];
  return sum;
}

/* The vectors from `first` on: those with more than half of their square along the nearby ones last, since their frame
 * has turned by a few hundredths only. */
static bool compare_block(const comparison *c, int first, int count, bool *lasting) {
  size_t rows = (size_t)c->a->rows;
  double size[BLOCK], along[BLOCK], squares[BLOCK];
  for (int k = 0; k < count; ++k) {
    double *v = c->v + (size_t)k * rows;
    make_vector(c, first + k, v);
    size[k] = square(v, c->a->rows);
    along[k] = along_local(c, v) + (c->span ? 0.0 : along_whole(c, v));
  }
  if (c->span && !km_sparse_qr_projected_squares(c->span, c->v, count, squares))
    return false;
  for (int k = 0; k < count; ++k)
    lasting[first + k] = along[k] + (c->span ? squares[k] : 0.0) > 0.5 * size[k];
  return true;
}

static bool compare_all(comparison *c, bool *lasting) {
  int total = km_left_null_count(c->null);
  bool done = true;
  c->v = KM_NEW(double, (size_t)BLOCK *(size_t)c->a->rows);
  for (int first = 0; first < total && done; first += BLOCK)
    done = c->v && compare_block(c, first, total - first < BLOCK ? total - first : BLOCK, lasting);
  km_free(c->v);
  return done;
}

km_status km_persistent_redundancy_find(const km_left_space *a, const km_left_null *null, const double *local,
                                        const km_left_null *nearby, bool *lasting, km_error *error) {
  comparison c = {.a = a, .null = null, .nearby = nearby, .local = local};
  if (km_left_null_count(nearby) == km_left_null_count(null)) { /* all of them last */
    memset(lasting, true, (size_t)km_left_null_count(null) * sizeof *lasting);
    return KM_OK;
  }
  km_status status = find_span(&c, error);
  if (!status && !compare_all(&c, lasting))
    status = KM_MEMORY;
  km_sparse_qr_free(c.span);
  return status;
}
