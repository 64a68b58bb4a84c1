/* Steps with bounds: against the best of all sets of active rows, on random problems with dependent rows. */
#include "support/support.h"

#include "base/number/vectors.h"
#include "base/random.h"
#include "space/real_solve.h"
#include "space/volume/bounded_step.h"

#include <string.h>

enum { MOST = 4, BOUNDS = 8, SEEDS = 2000 };

/* ½ |A w − d|² + ½ ε |w|². */
static double objective(const km_bounded_step *g, const double *d, double epsilon, const double *w) {
  double sum = epsilon * km_dot(w, w, g->columns);
  for (int r = 0; r < g->rows; ++r) {
    double rest = d[r];
    for (int k = 0; k < g->columns; ++k)
      rest -= g->A[k * g->rows + r] * w[k];
    sum += rest * rest;
  }
  return 0.5 * sum;
}

/* Largest excess of w over the bounds. */
static double largest_excess(const km_bounded_step *g, const double *w) {
  double most = -HUGE_VAL;
  for (int i = 0; i < g->bound_count; ++i)
    most = fmax(most, km_dot(g->bound + i * g->most_columns, w, g->columns) - g->slack[i]);
  return most;
}

/* Solves with the bounds of a set as equations. False where they depend on each other. */
static bool solve_with(const km_bounded_step *g, const double *d, double epsilon, int set, double *w) {
  double M[4 * MOST * MOST] = {0}, b[2 * MOST], x[2 * MOST];
  int n = g->columns, active[BOUNDS], count = 0, pivot[2 * MOST], sign;
  for (int i = 0; i < g->bound_count; ++i)
    if (set & 1 << i)
      active[count++] = i;
  if (count > n)
    return false;
  int order = n + count;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j)
      M[i * order + j] = km_dot(g->A + i * g->rows, g->A + j * g->rows, g->rows) + (i == j ? epsilon : 0.0);
    b[i] = km_dot(g->A + i * g->rows, d, g->rows);
    for (int a = 0; a < count; ++a)
      M[i * order + n + a] = M[(n + a) * order + i] = g->bound[active[a] * g->most_columns + i];
  }
  for (int a = 0; a < count; ++a)
    b[n + a] = g->slack[active[a]];
  if (!km_real_factor(M, order, pivot, &sign))
    return false;
  km_real_solve(M, order, pivot, b, x);
  memcpy(w, x, (size_t)n * sizeof *w);
  return isfinite(km_norm(x, order));
}

/* The least objective of all sets within the bounds; infinite: no step is. */
static double best_of_sets(const km_bounded_step *g, const double *d, double epsilon) {
  double best = HUGE_VAL, w[MOST];
  for (int set = 0; set < 1 << g->bound_count; ++set)
    if (solve_with(g, d, epsilon, set, w) && largest_excess(g, w) <= 1e-9)
      best = fmin(best, objective(g, d, epsilon, w));
  return best;
}

/* Rows of small integers, of which many depend on others; slacks of 0 and 1, few of −1. */
static void set_random_problem(km_bounded_step *g, uint64_t *random, double *d) {
  g->rows = 1 + (int)km_splitmix(random, 0.0, 3.0);
  g->columns = 1 + (int)km_splitmix(random, 0.0, MOST);
  g->bound_count = (int)km_splitmix(random, 0.0, BOUNDS + 1.0);
  for (int i = 0; i < g->rows * g->columns; ++i)
    g->A[i] = km_splitmix(random, -1.0, 1.0);
  for (int i = 0; i < g->bound_count; ++i) {
    for (int k = 0; k < g->columns; ++k)
      g->bound[i * g->most_columns + k] = floor(km_splitmix(random, -1.0, 2.0));
    g->slack[i] = fmax(floor(km_splitmix(random, -8.0, 2.0)), km_splitmix(random, -1.05, 1.0) < -1.0 ? -1.0 : 0.0);
  }
  for (int r = 0; r < g->rows; ++r)
    d[r] = km_splitmix(random, -3.0, 3.0);
}

/* The systems of a set have a condition below 1e4, and the objective an error of 1e-12 of it. */
static void steps_are_the_best_of_all_sets(void **state) {
  (void)state;
  km_arena arena = {0};
  km_bounded_step g;
  int bounded = 0, excluded = 0;
  assert_true(km_bounded_step_create(&g, MOST, BOUNDS, &arena));
  for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
    uint64_t random = seed;
    double d[3], epsilon = 0.01;
    set_random_problem(&g, &random, d);
    double best = best_of_sets(&g, d, epsilon);
    bool is_found = km_bounded_step_find(&g, d, epsilon);
    if (is_found != isfinite(best))
      fail_msg("seed %d: a step is %sfound, the best is %g", (int)seed, is_found ? "" : "not ", best);
    excluded += !is_found;
    if (!is_found)
      continue;
    bounded += g.active_count > 0;
    assert_true(largest_excess(&g, g.w) <= 1e-9);
    assert_near(objective(&g, d, epsilon, g.w), best, 1e-8 * (1.0 + best));
  }
  assert_true(bounded > SEEDS / 4);
  assert_true(excluded > SEEDS / 100);
  km_arena_free(&arena);
}

/* One row, four columns, hardly any damping: three motions don't move the point, which goes up to a bound of each. */
static void small_damping_keeps_its_digits(void **state) {
  (void)state;
  km_arena arena = {0};
  km_bounded_step g;
  const double d[1] = {10.0};
  assert_true(km_bounded_step_create(&g, MOST, BOUNDS, &arena));
  g.rows = 1;
  g.columns = g.bound_count = MOST;
  for (int k = 0; k < MOST; ++k) {
    g.A[k] = 1.0 + 0.1 * k;
    memset(g.bound + k * g.most_columns, 0, MOST * sizeof *g.bound);
    g.bound[k * g.most_columns + k] = 1.0;
    g.slack[k] = 0.5;
  }
  assert_true(km_bounded_step_find(&g, d, 1e-22));
  for (int k = 0; k < MOST; ++k)
    assert_near(g.w[k], 0.5, 1e-7);
  km_arena_free(&arena);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(steps_are_the_best_of_all_sets),
      cmocka_unit_test(small_damping_keeps_its_digits),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
