/* Damped least-squares step with bounds (space/volume/bounded_step.h). */
#include "space/volume/bounded_step.h"

#include "base/number/vectors.h"
#include "space/real_solve.h"

#include <string.h>

static const double rounding = 1e-12; /* excess over a bound, scaled; multiplier over 1 + |d| */

bool km_bounded_step_create(km_bounded_step *g, int most_columns, int most_bounds, km_arena *arena) {
  size_t n = (size_t)most_columns, bounds = (size_t)most_bounds + 1, order = 2 * n;
  *g = (km_bounded_step){.most_columns = most_columns, .most_bounds = most_bounds};
  g->A = KM_ARENA_NEW(arena, double, 3 * n);
  g->bound = KM_ARENA_NEW(arena, double, bounds *n);
  g->slack = KM_ARENA_NEW(arena, double, bounds);
  g->w = KM_ARENA_NEW(arena, double, n);
  g->matrix = KM_ARENA_NEW(arena, double, order *order);
  g->right = KM_ARENA_NEW(arena, double, order);
  g->solution = KM_ARENA_NEW(arena, double, order);
  g->pivot = KM_ARENA_NEW(arena, int, order);
  g->active = KM_ARENA_NEW(arena, int, n);
  g->is_active = KM_ARENA_NEW(arena, bool, bounds);
  return !arena->failed;
}

/* Solves for w and λ of the active rows. False if these depend on each other. */
static bool solve(km_bounded_step *g, const double *d, double epsilon, int active) {
  int n = g->columns, order = n + active, sign;
  memset(g->matrix, 0, (size_t)(order * order) * sizeof *g->matrix);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j)
      g->matrix[i * order + j] = km_dot(g->A + i * g->rows, g->A + j * g->rows, g->rows) + (i == j ? epsilon : 0.0);
    g->right[i] = km_dot(g->A + i * g->rows, d, g->rows);
  }
  for (int a = 0; a < active; ++a) {
    const double *row = g->bound + g->active[a] * g->most_columns;
    for (int i = 0; i < n; ++i)
      g->matrix[(n + a) * order + i] = g->matrix[i * order + n + a] = row[i];
    g->right[n + a] = g->slack[g->active[a]];
  }
  if (!km_real_factor(g->matrix, order, g->pivot, &sign))
    return false;
  km_real_solve(g->matrix, order, g->pivot, g->right, g->solution);
  memcpy(g->w, g->solution, (size_t)n * sizeof *g->w);
  return isfinite(km_norm(g->solution, order));
}

/* The bound that the step exceeds most; −1: none. */
static int most_exceeded(const km_bounded_step *g) {
  int most = -1;
  double excess = rounding;
  for (int i = 0; i < g->bound_count; ++i) {
    double by = km_dot(g->bound + i * g->most_columns, g->w, g->columns) - g->slack[i];
    if (!g->is_active[i] && by > excess) {
      excess = by;
      most = i;
    }
  }
  return most;
}

/* The active row with the most negative multiplier; −1: none. */
static int wrong_side(const km_bounded_step *g, int active, double least) {
  int wrong = -1;
  for (int a = 0; a < active; ++a)
    if (g->solution[g->columns + a] < least) {
      least = g->solution[g->columns + a];
      wrong = a;
    }
  return wrong;
}

bool km_bounded_step_find(km_bounded_step *g, const double *d, double epsilon) {
  int active = 0;
  memset(g->is_active, 0, (size_t)(g->bound_count + 1) * sizeof *g->is_active);
  for (int i = 0; i < 4 * (g->columns + 1); ++i) {
    if (!solve(g, d, epsilon, active))
      return false;
    int wrong = wrong_side(g, active, -rounding * (1.0 + km_norm(d, g->rows)));
    if (wrong >= 0) {
      g->is_active[g->active[wrong]] = false;
      g->active[wrong] = g->active[--active];
      continue;
    }
    int exceeded = most_exceeded(g);
    if (exceeded < 0)
      return true;
    if (active == g->columns)
      return false;
    g->is_active[exceeded] = true;
    g->active[active++] = exceeded;
  }
  return false;
}

double km_bounded_step_decrease(const km_bounded_step *g, const double *d) {
  double square = 0.0;
  for (int r = 0; r < g->rows; ++r) {
    double rest = d[r];
    for (int k = 0; k < g->columns; ++k)
      rest -= g->A[k * g->rows + r] * g->w[k];
    square += rest * rest;
  }
  return km_dot(d, d, g->rows) - square;
}
