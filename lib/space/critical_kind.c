/* Kind of a critical value of a design's number (space/critical_kind.h). */
#include "space/critical_kind.h"
#include "base/number/vectors.h"

#include "linalg/dense/singular_values.h"

#include <string.h>

static const double full_rank = 1e-5;  /* smallest singular value of J over the largest: it is 0 to about 1e-9 */
static const double difference = 1e-5; /* step of the central differences of J: their error is 1e-10 */

/* q <- wᵀ (J(q + δ n) − J(q − δ n)) / 2δ. n[columns], w[rows], q[columns]: joints only. */
static void second_derivative(km_driver_surface *f, int columns, const double *n, const double *w, double *q) {
  memset(q, 0, (size_t)columns * sizeof *q);
  for (int side = 0; side < 3; ++side) { /* forward, backward, and return to the configuration */
    double by = side == 1 ? -2.0 * difference : difference;
    for (int k = 0; k < columns; ++k)
      f->step[k] = by * n[k];
    f->step[f->columns - 1] = 0.0;
    km_driver_surface_move(f, f->step);
    km_driver_surface_update(f);
    for (int k = 0; side < 2 && k < columns; ++k)
      for (int i = 0; i < f->rows; ++i)
        q[k] += (side == 0 ? 0.5 : -0.5) / difference * w[i] * f->J[k * f->rows + i];
  }
}

bool km_critical_kind(km_driver_surface *f, km_turning_kind *kind) {
  int r = f->rows, columns = f->columns - 1; /* columns = r + 1 */
  size_t n = (size_t)columns;
  km_arena arena = {0};
  double *J = KM_ARENA_NEW(&arena, double, (size_t)r *n), *s = KM_ARENA_NEW(&arena, double, n);
  double *U = KM_ARENA_NEW(&arena, double, (size_t)(r * r)), *Vt = KM_ARENA_NEW(&arena, double, n *n);
  double *null = KM_ARENA_NEW(&arena, double, 2 * n), *q = KM_ARENA_NEW(&arena, double, n);
  bool is_ok = !arena.failed;
  if (is_ok) {
    km_driver_surface_update(f);
    memcpy(J, f->J, (size_t)r * n * sizeof *J);
    is_ok = !km_singular_value_decomposition(r, columns, J, true, s, U, Vt, NULL);
  }
  if (is_ok && s[r - 1] > full_rank * s[0])
    *kind = KM_TURNING_CUSP;
  else if (is_ok) {
    double Q[3];
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < columns; ++k)
        null[i * columns + k] = Vt[k * columns + r - 1 + i];
    second_derivative(f, columns, null, U + (r - 1) * r, q);
    Q[0] = km_dot(q, null, columns);
    Q[1] = km_dot(q, null + columns, columns);
    second_derivative(f, columns, null + columns, U + (r - 1) * r, q);
    Q[2] = km_dot(q, null + columns, columns);
    *kind = Q[0] * Q[2] - Q[1] * Q[1] > 0.0 ? KM_TURNING_ISOLATED : KM_TURNING_CROSSING;
  }
  km_arena_free(&arena);
  return is_ok;
}
