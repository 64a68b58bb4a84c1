/* Damped least-squares step with bounds (space/volume/bounded_step.h). */
#include "space/volume/bounded_step.h"

#include "base/number/vectors.h"
#include "space/real_solve.h"

#include <string.h>

static const double rounding = 1e-12; /* excess over a bound, scaled: coordinates and rows are exact to it */
static const double dependence_tolerance =
    1e-9; /* part of a row that others leave, and that their rounding may have left */
static const double least_damping =
    1e-8; /* ε over |A|²: H keeps half the digits in motions that don't move the point */
enum { MOST_CHANGES = 4 /* changes of a bound: without rounding no set of active ones returns; models/ take 1.5 */ };

bool km_bounded_step_create(km_bounded_step *g, int most_columns, int most_bounds, km_arena *arena) {
  size_t n = (size_t)most_columns, bounds = (size_t)most_bounds + 1, order = 2 * n;
  *g = (km_bounded_step){.most_columns = most_columns, .most_bounds = most_bounds};
  g->A = KM_ARENA_NEW(arena, double, 3 * n);
  g->bound = KM_ARENA_NEW(arena, double, bounds *n);
  g->slack = KM_ARENA_NEW(arena, double, bounds);
  g->w = KM_ARENA_NEW(arena, double, n);
  g->lambda = KM_ARENA_NEW(arena, double, n);
  g->matrix = KM_ARENA_NEW(arena, double, order *order);
  g->right = KM_ARENA_NEW(arena, double, order);
  g->solution = KM_ARENA_NEW(arena, double, order);
  g->pivot = KM_ARENA_NEW(arena, int, order);
  g->active = KM_ARENA_NEW(arena, int, n);
  g->is_active = KM_ARENA_NEW(arena, bool, bounds);
  return !arena->failed;
}

static const double *row_of(const km_bounded_step *g, int bound) {
  return g->bound + bound * g->most_columns;
}

/* Solves (H  N_Sᵀ; N_S  0) solution = right, H = Aᵀ A + ε I. False where it is singular. */
static bool solve(km_bounded_step *g, double epsilon) {
  int n = g->columns, order = n + g->active_count, sign;
  memset(g->matrix, 0, (size_t)(order * order) * sizeof *g->matrix);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      g->matrix[i * order + j] = km_dot(g->A + i * g->rows, g->A + j * g->rows, g->rows) + (i == j ? epsilon : 0.0);
  for (int a = 0; a < g->active_count; ++a)
    for (int i = 0; i < n; ++i)
      g->matrix[(n + a) * order + i] = g->matrix[i * order + n + a] = row_of(g, g->active[a])[i];
  if (!km_real_factor(g->matrix, order, g->pivot, &sign))
    return false;
  km_real_solve(g->matrix, order, g->pivot, g->right, g->solution);
  return isfinite(km_norm(g->solution, order));
}

/* The step without bounds. */
static bool find_free_step(km_bounded_step *g, const double *d, double epsilon) {
  g->active_count = 0;
  memset(g->is_active, 0, (size_t)(g->bound_count + 1) * sizeof *g->is_active);
  for (int i = 0; i < g->columns; ++i)
    g->right[i] = km_dot(g->A + i * g->rows, d, g->rows);
  if (!solve(g, epsilon))
    return false;
  memcpy(g->w, g->solution, (size_t)g->columns * sizeof *g->w);
  return true;
}

/* The bound that the step exceeds most; −1: none. */
static int most_exceeded(const km_bounded_step *g) {
  int most = -1;
  double excess = rounding;
  for (int i = 0; i < g->bound_count; ++i) {
    double by = km_dot(row_of(g, i), g->w, g->columns) - g->slack[i];
    if (!g->is_active[i] && by > excess) {
      excess = by;
      most = i;
    }
  }
  return most;
}

/* Solves for z and y of a bound's row: the changes of w and λ with its multiplier. */
static bool find_direction(km_bounded_step *g, int bound, double epsilon) {
  memset(g->right, 0, (size_t)(g->columns + g->active_count) * sizeof *g->right);
  for (int i = 0; i < g->columns; ++i)
    g->right[i] = -row_of(g, bound)[i];
  return solve(g, epsilon);
}

/* True if the active rows leave rounding of a bound's row, n + N_Sᵀ y. */
static bool is_dependent(const km_bounded_step *g, int bound) {
  const double *y = g->solution + g->columns;
  double rest = 0.0, size = km_norm(row_of(g, bound), g->columns);
  for (int i = 0; i < g->columns; ++i) {
    double sum = row_of(g, bound)[i];
    for (int a = 0; a < g->active_count; ++a)
      sum += y[a] * row_of(g, g->active[a])[i];
    rest = hypot(rest, sum);
  }
  for (int a = 0; a < g->active_count; ++a)
    size += fabs(y[a]) * km_norm(row_of(g, g->active[a]), g->columns);
  return g->active_count == g->columns || rest <= dependence_tolerance * size;
}

/* The active row whose multiplier reaches 0 first, after *t; −1: none does. */
static int first_released(const km_bounded_step *g, double *t) {
  const double *y = g->solution + g->columns;
  int first = -1;
  *t = HUGE_VAL;
  for (int a = 0; a < g->active_count; ++a)
    if (y[a] < 0.0 && g->lambda[a] / -y[a] < *t) {
      *t = g->lambda[a] / -y[a];
      first = a;
    }
  return first;
}

static void release(km_bounded_step *g, int a) {
  g->is_active[g->active[a]] = false;
  --g->active_count;
  g->active[a] = g->active[g->active_count];
  g->lambda[a] = g->lambda[g->active_count];
}

static void activate(km_bounded_step *g, int bound, double lambda) {
  g->is_active[bound] = true;
  g->active[g->active_count] = bound;
  g->lambda[g->active_count++] = lambda;
}

/* Moves the step to a bound that it exceeds, and releases active ones on the way. False: the bounds exclude each
 * other. */
static bool satisfy(km_bounded_step *g, int bound, double epsilon) {
  double lambda = 0.0, until_released;
  for (;;) {
    if (!find_direction(g, bound, epsilon))
      return false;
    int released = first_released(g, &until_released);
    double until_met = HUGE_VAL;
    if (!is_dependent(g, bound)) {
      double by = km_dot(row_of(g, bound), g->w, g->columns) - g->slack[bound];
      until_met = by / -km_dot(row_of(g, bound), g->solution, g->columns);
    }
    double t = fmin(until_met, until_released);
    if (!isfinite(t))
      return false;
    for (int i = 0; i < g->columns && isfinite(until_met); ++i)
      g->w[i] += t * g->solution[i];
    for (int a = 0; a < g->active_count; ++a)
      g->lambda[a] += t * g->solution[g->columns + a];
    lambda += t;
    if (until_met <= until_released) {
      activate(g, bound, lambda);
      return true;
    }
    release(g, released);
  }
}

bool km_bounded_step_find(km_bounded_step *g, const double *d, double damping) {
  double epsilon = fmax(damping, least_damping * km_dot(g->A, g->A, g->rows * g->columns));
  if (!find_free_step(g, d, epsilon))
    return false;
  for (int i = 0; i < MOST_CHANGES * (g->bound_count + 1); ++i) {
    int exceeded = most_exceeded(g);
    if (exceeded < 0)
      return true;
    if (!satisfy(g, exceeded, epsilon))
      return false;
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
