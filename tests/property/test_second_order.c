/* The conditions of second order: what they say of a direction, and of the pose by a single one. */
#include "support/folded.h"
#include "support/linkages.h"

#include "kinematics/loop_equations.h"
#include "local/local_private.h"

#include <lapacke.h>

/* Sixteen panels in a plane, hinged at their sides: a loop about each inner corner. */
static linkage flat_sheet(randomness *r) {
  enum { SIDE = 4 };
  linkage l = {.bodies = SIDE * SIDE - 1};
  km_vec3 corner[SIDE + 1][SIDE + 1];
  for (int i = 0; i <= SIDE; ++i)
    for (int k = 0; k <= SIDE; ++k)
      corner[i][k] = (km_vec3){k + uniform(r, -0.2, 0.2), i + uniform(r, -0.2, 0.2), 0.0};
  for (int i = 0; i < SIDE; ++i)
    for (int k = 0; k < SIDE; ++k)
      for (int next = 0; next < 2; ++next) {
        int row = i + (next == 0), column = k + (next == 1);
        if (row == SIDE || column == SIDE)
          continue;
        km_vec3 side = km_vec3_sub(corner[i + 1][k + 1], corner[row][column]);
        l.joint[l.joints++] = (axis_joint){SIDE * i + k, SIDE * row + column, false, corner[row][column],
                                           km_vec3_scale(1.0 / km_vec3_norm(side), side)};
      }
  return l;
}

/* A four-bar on one line: finitely mobile if a = c and b = d, otherwise infinitesimally mobile. */
static linkage flat_fourbar(randomness *r) {
  double crank = uniform(r, 0.2, 0.8), base = uniform(r, 1, 2), rocker = below(r, 2) ? crank : uniform(r, 0.2, 0.8);
  const km_vec3 z = {0, 0, 1}, along[4] = {z, z, z, z};
  const km_vec3 at[4] = {{0, 0, 0}, {crank, 0, 0}, {base + rocker, 0, 0}, {base, 0, 0}};
  return hinged_loop(at, along, 4);
}

enum { KINDS = 4 };

static fixture any(int kind, randomness *r) {
  linkage l = kind == 0 ? flat_sheet(r) : kind == 1 ? flat_fourbar(r) : moving_loop(below(r, MOVING_KINDS), r);
  return kind == 3 ? folded_chain(1 + below(r, 4)) : linkage_open(&l, r);
}

/* The tangents at the pose, with their conditions. */
static km_local *make(fixture *f, km_arena *arena) {
  km_local *t = km_local_create(f->mechanism, f->state, 0, NULL, 0.0, arena);
  assert_true(t && km_local_reserve_tangents(t, true) && km_local_update_conditions(t));
  return t;
}

/* The square of what no accelerations J q̈ make of γ = −J̇ q̇, by least squares. */
static double left_of(const fixture *f, const km_local *t, const double *x) {
  const km_mechanism *m = f->mechanism;
  int rows = t->sub->rows, columns = t->sub->columns, larger = rows > columns ? rows : columns, rank;
  double *J = KM_NEW(double, (size_t)(rows * columns)), *b = KM_NEW(double, (size_t)larger);
  double *y = KM_NEW(double, (size_t)larger), *singular = KM_NEW(double, (size_t)larger), square = 0.0;
  double *rate = KM_NEW(double, (size_t)m->coordinate_count), *whole = KM_NEW(double, (size_t)(rows * columns));
  km_loops_update(m, f->state, t->sub);
  km_state_jacobian_dense(f->state, t->sub, J);
  for (int c = 0; c < columns; ++c) {
    int coordinate = m->column_coordinate[t->sub->column_start + c];
    rate[coordinate] = m->unit[coordinate] * x[c];
  }
  km_loops_velocity_products(m, f->state, t->sub, rate, b);
  for (int i = 0; i < rows * columns; ++i)
    whole[i] = J[i];
  for (int i = 0; i < rows; ++i)
    y[i] = b[i];
  assert_int_equal(LAPACKE_dgelsd(LAPACK_COL_MAJOR, rows, columns, 1, J, rows, y, larger, singular, 1e-8, &rank), 0);
  for (int i = 0; i < rows; ++i) {
    double left = b[i];
    for (int c = 0; c < columns; ++c)
      left -= whole[c * rows + i] * y[c];
    square += left * left;
  }
  km_free(J);
  km_free(b);
  km_free(y);
  km_free(singular);
  km_free(rate);
  km_free(whole);
  return square;
}

/* Σ (aᵀQ_i a)² is the square of what is left of γ. */
static void what_rates_leave(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 80; ++seed) {
    randomness r = {seed};
    fixture f = any((int)(seed % KINDS), &r);
    km_arena arena = {0};
    km_local *t = make(&f, &arena);
    int k = t->freedom;
    assert_int_equal(t->conditions, t->sub->rows - (t->sub->columns - k));
    for (int i = 0; i < k; ++i)
      t->a[i] = uniform(&r, -1.0, 1.0);
    assert_true(k == 0 || km_local_normalise(t, t->a) > 0.0);
    km_local_direction(t, t->a, t->direction);
    double sum = 0.0, size = fmax(t->scale, t->noise);
    for (int i = 0; i < t->conditions; ++i) {
      double value = 0.0;
      for (int a = 0; a < k; ++a)
        for (int b = 0; b < k; ++b)
          value += t->Q[(i * k + a) * k + b] * t->a[a] * t->a[b];
      sum += value * value;
    }
    assert_near((sum - left_of(&f, t, t->direction)) / (size * size), 0.0, 1e-9);
    km_arena_free(&arena);
    fixture_close(&f);
  }
}

/* One tangent decides for all: the basis vectors and random combinations of them. */
static bool are_all_finite(km_local *t, randomness *r) {
  bool all = true;
  for (int attempt = 0; attempt < 2 * t->freedom && all; ++attempt) {
    for (int i = 0; i < t->freedom; ++i)
      t->a[i] = attempt < t->freedom ? attempt == i : uniform(r, -1.0, 1.0);
    all = km_local_normalise(t, t->a) > 0.0 && km_local_is_finite(t, t->a);
  }
  return all;
}

static void one_tangent_tells(void **state) {
  (void)state;
  int regular = 0;
  for (uint64_t seed = 1; seed <= 120; ++seed) {
    randomness r = {seed};
    fixture f = any((int)(seed % KINDS), &r);
    km_arena arena = {0};
    km_local *t = make(&f, &arena);
    bool is_regular = km_local_is_regular(t);
    regular += is_regular;
    assert_int_equal(is_regular, are_all_finite(t, &r));
    km_arena_free(&arena);
    fixture_close(&f);
  }
  assert_true(regular > 20 && regular < 60);
}

/* Where the pose doesn't fit to rounding, as many as twice the freedom prove something. */
static void rounded_poses(void **state) {
  (void)state;
  randomness r = {1};
  linkage l = moving_loop(0, &r);
  char *json = linkage_text(&l, (writing){.digits = 7, .tolerance = 1e-5}, &r);
  fixture f = fixture_read(json);
  km_arena arena = {0};
  km_local *t = make(&f, &arena);
  assert_false(km_local_is_exact(t));
  assert_true(km_local_is_regular(t));
  km_arena_free(&arena);
  fixture_close(&f);
  km_free(json);
}

/* The branches of a folded chain are curves, as the derivatives of their conditions show. */
static void branches_are_curves(void **state) {
  (void)state;
  enum { LOOPS = 4, BRANCHES = 1 << LOOPS };
  fixture f = folded_chain(LOOPS);
  km_arena arena = {0};
  km_local *t = make(&f, &arena);
  double *known = KM_ARENA_NEW(&arena, double, (size_t)(BRANCHES * t->freedom)), length;
  int count = 0, k = t->freedom;
  while (km_local_find_next(t, known, count, &length)) {
    assert_true(count < BRANCHES && length > 0.3);
    assert_int_equal(km_local_dimension_bound(t, t->a), 1);
    for (int i = 0; i < k; ++i)
      known[count * k + i] = t->a[i];
    ++count;
  }
  assert_int_equal(count, BRANCHES);
  km_arena_free(&arena);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_rates_leave),
      cmocka_unit_test(one_tangent_tells),
      cmocka_unit_test(rounded_poses),
      cmocka_unit_test(branches_are_curves),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
