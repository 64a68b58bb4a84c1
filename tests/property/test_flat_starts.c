/* Leaving a pose where the loops stretch: the closest poses, and the path of least motion that begins there. */
#include "support/chains.h"
#include "support/lattices.h"
#include "support/laws.h"
#include "support/random_mechanism.h"
#include "support/sheets.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kinematics/nearest_configuration.h"
#include "kmech/sweep.h"
#include "local/local.h"
#include "model/model.h"
#include "topology/mechanism.h"

#include <stdio.h>
#include <string.h>

static void write_bent(km_text *text, int n) {
  write_five_bars(text, n, 0.0);
}

static void write_fold(km_text *text, int n) {
  write_miura(text, n, n, 0.0);
}

/* For J x = 0, the rows' second derivatives along x are −γ(x): Σ λ_r xᵀ ∂²e_r x = −λᵀ γ(x) for every λ. */
static void bends_are_velocity_products(fixture *f, randomness *r) {
  const km_mechanism *m = f->mechanism;
  for (int s = 0; s < m->topology.substructure_count && m->ball_count == 0; ++s) {
    const km_substructure *sub = &m->substructures[s];
    size_t rows = (size_t)sub->rows, columns = (size_t)sub->columns;
    int count = km_loops_hessian_entries(m, sub, NULL), *pairs = KM_NEW(int, 2 * (size_t)count + 1);
    double *x = KM_NEW(double, columns), *part = KM_NEW(double, columns), *own = KM_NEW(double, columns);
    double *rate = KM_NEW(double, (size_t)m->coordinate_count), *pair = KM_NEW(double, (size_t)count + 1);
    double *lambda = KM_NEW(double, rows), *gamma = KM_NEW(double, rows), sum = 0.0, product = 0.0, size = 0.0;
    km_loops_update(m, f->state, sub);
    km_search_pivots(m, f->state, s, KM_NO_DRIVER, km_rank_tolerance(m, sub, 0.0));
    for (size_t k = 0; k < columns; ++k)
      x[k] = uniform(r, -1.0, 1.0);
    bool moves = km_factor_freedom(f->state->factor[s]) > 0 && km_tangent_project(m, f->state, s, x, part) > 1e-3;
    for (size_t k = 0; k < columns; ++k) {
      int c = m->column_coordinate[(size_t)sub->column_start + k];
      rate[c] = m->unit[c] * x[k];
    }
    for (size_t i = 0; i < rows; ++i)
      lambda[i] = uniform(r, -1.0, 1.0);
    km_loops_velocity_products(m, f->state, sub, rate, gamma);
    km_loops_hessian_entries(m, sub, pairs);
    km_loops_hessian(m, f->state, sub, lambda, pair, own);
    for (int i = 0; i < count; ++i) {
      double term = 2.0 * pair[i] * x[pairs[2 * i]] * x[pairs[2 * i + 1]];
      sum += term;
      size += fabs(term);
    }
    for (size_t k = 0; k < columns; ++k)
      sum += own[k] * x[k] * x[k];
    for (size_t i = 0; i < rows; ++i)
      product -= lambda[i] * gamma[i];
    if (moves)
      assert_near(sum, product, 1e-11 * (1.0 + size));
    void *const all[] = {pairs, x, part, own, rate, pair, lambda, gamma};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
      km_free(all[i]);
  }
}

static void loops_bend_as_they_accelerate(void **state) {
  (void)state;
  randomness r = {1};
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    bends_are_velocity_products(&f, &r);
    fixture_close(&f);
  }
  fixture others[] = {fixture_written(write_bent, 5), fixture_written(write_fold, 3), fixture_written(write_chain, 4)};
  for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
    bends_are_velocity_products(&others[i], &r);
    fixture_close(&others[i]);
  }
}

/* From the closed pose that is closest to y the way to y is at right angles, by D, to every motion that leaves the
 * driver alone; and no pose that least steps find from y is closer. */
static void judge_closest(fixture *f, double apart, randomness *r) {
  const km_mechanism *m = f->mechanism;
  const km_substructure *sub = &m->substructures[0];
  size_t n = (size_t)sub->columns;
  int driver = 0;
  km_arena arena = {0};
  km_nearest_configuration closest;
  km_closure evidence;
  double *y = KM_NEW(double, 3 * n), *away = KM_NEW(double, n), *rest = KM_NEW(double, n);
  assert_true(km_nearest_configuration_reserve(&closest, m, sub, &arena));
  for (size_t k = 0; k < n; ++k)
    away[k] = (int)k == driver ? 0.0 : uniform(r, -apart, apart);
  km_state_move(m, f->state, sub, away);
  km_state_save(f->state, sub, y);
  assert_int_equal(km_loops_close(m, f->state, 0, driver, &evidence), KM_CLOSED);
  km_state_difference(f->state, sub, y, away);
  double length = km_step_length(m, sub, away);
  assert_true(km_nearest_configuration_find(&closest, m, f->state, 0, driver, f->state->factor[0], away));
  km_state_difference(f->state, sub, y, rest);
  for (size_t k = 0; k < n; ++k)
    assert_near(rest[k], away[k], 1e-12);
  assert_true(km_step_length(m, sub, away) <= length * (1.0 + 1e-12));
  assert_int_equal(km_loops_close(m, f->state, 0, driver, &evidence), KM_CLOSED);
  assert_at_most(evidence.correction, 1e-9);
  km_minimum_norm_step(m, f->state, 0, driver, rest);
  for (size_t k = 0; k < n; ++k)
    assert_near(rest[k], away[k], 1e-9);
  km_free(y);
  km_free(away);
  km_free(rest);
  km_arena_free(&arena);
}

static void closest_poses_lie_at_right_angles(void **state) {
  (void)state;
  randomness r = {2};
  for (int n = 1; n <= 60; n += n < 8 ? 1 : 26) {
    fixture f = fixture_written(write_bent, n);
    judge_closest(&f, 0.05, &r);
    fixture_close(&f);
  }
}

static km_mobility_sweep sweep_flat(int n, int steps) {
  fixture f = fixture_written(write_flat_five_bars, n);
  assert_string_equal(f.model->coordinates[0].label, "j0");
  const km_sweep_plan plan = {.coordinate = 0, .direction = -1, .from = 0.0, .to = 0.05, .steps = steps};
  km_mobility_sweep sweep;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
  fixture_close(&f);
  return sweep;
}

/* A chain of five-bars stretched between their cranks: each crank rotates at least as far as the previous one,
 * equally in the same sense or 1.35 times in the other; farther only if the dyad folds, which takes a longer path.
 * The motion begins at the file's configuration and doesn't depend on the division of the range. */
static void stretched_five_bars_move_least(void **state) {
  (void)state;
  static const int sizes[] = {2, 10, 60};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    km_mobility_sweep coarse = sweep_flat(sizes[i], 5), fine = sweep_flat(sizes[i], 40);
    const km_table *a = coarse.motion.table, *b = fine.motion.table;
    int shown = 1 + 4 * sizes[i];
    assert_true(coarse.motion.start_branches > 0);
    assert_int_equal(km_table_rows(b), 41);
    for (int c = 0; c < shown; ++c)
      assert_at_most(km_table_row(a, 0)[2 + c], 1e-15);
    for (size_t row = 0; row <= 5; ++row)
      for (int c = 0; c < shown; ++c)
        assert_near(km_table_row(a, row)[2 + c], km_table_row(b, 8 * row)[2 + c], 1e-6);
    double last = 0.05;
    for (int k = 0; k <= sizes[i]; ++k) {
      char name[16];
      snprintf(name, sizeof name, "q.j%d", k);
      int column = km_table_find(a, name);
      assert_true(column >= 0);
      double turn = km_table_row(a, 5)[column];
      assert_true(fabs(turn) >= last - 1e-12 && fabs(turn) <= 1.4 * last);
      last = fabs(turn);
    }
    km_mobility_sweep_free(&coarse);
    km_mobility_sweep_free(&fine);
  }
}

/* So the last crank rotates at least as far as the first one, from the flat configuration with its higher
 * instantaneous mobility on: the mechanical advantage is finite everywhere, and there is no branch point after the
 * first row. */
static void flat_five_bars_have_leverage(void **state) {
  (void)state;
  static const int sizes[] = {2, 5, 10, 40};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    fixture f = fixture_written(write_flat_five_bars, sizes[i]);
    const km_sweep_plan plan = {.coordinate = 0, .direction = -1, .from = 0.0, .to = 0.3, .steps = 20};
    const km_port in = {.kind = KM_PORT_JOINT, .coordinate = 0, .name = "in"},
                  out = {.kind = KM_PORT_JOINT, .coordinate = sizes[i], .name = "out"};
    km_advantage_sweep sweep;
    assert_int_equal(km_advantage_sweep_run(f.mechanism, f.state, &plan, &in, &out, false, &sweep, NULL), KM_OK);
    assert_true(sweep.motion.start_branches > 0);
    assert_int_equal(sweep.motion.branch_count, 0);
    assert_int_equal(sweep.toggle_count, 0);
    for (size_t row = 0; row < km_table_rows(sweep.motion.table); ++row)
      assert_at_most(fabs(km_table_row(sweep.motion.table, row)[sweep.column]), 1.0);
    km_advantage_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* Loops far from the driver fold much less than those near it: short steps from the flat configuration close them,
 * too. */
static void short_steps_close_all_loops(void **state) {
  (void)state;
  for (int loops = 1; loops <= 3; ++loops) {
    fixture f = fixture_written(write_flat_five_bars, loops);
    const int last = f.model->coordinate_count - 1;
    const km_sweep_plan plan = {.coordinate = last, .direction = -1, .from = 0.0, .to = 1e-3, .steps = 10};
    km_mobility_sweep sweep;
    assert_string_equal(f.model->coordinates[last].label, "last");
    assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL), KM_OK);
    const km_table *table = sweep.motion.table;
    assert_int_equal(km_table_rows(table), 11);
    for (size_t row = 0; row < km_table_rows(table); ++row)
      assert_at_most(km_table_row(table, row)[km_table_columns(table) - 1], 1e-12); /* the residual */
    km_mobility_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* Far loops of such a long chain hardly fold at first: all rows are present, whichever end drives. */
static void long_rows_of_five_bars_move(void **state) {
  (void)state;
  fixture f = fixture_written(write_flat_five_bars, 1200);
  const int ends[2] = {0, f.model->coordinate_count - 1};
  for (int i = 0; i < 2; ++i) {
    fixture g = fixture_written(write_flat_five_bars, 1200);
    const km_sweep_plan plan = {.coordinate = ends[i], .direction = -1, .from = 0.0, .to = 0.1, .steps = 10};
    km_mobility_sweep sweep;
    assert_int_equal(km_mobility_sweep_run(g.mechanism, g.state, &plan, &sweep, NULL), KM_OK);
    assert_int_equal(km_table_rows(sweep.motion.table), 11);
    km_mobility_sweep_free(&sweep);
    fixture_close(&g);
  }
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(loops_bend_as_they_accelerate),  cmocka_unit_test(closest_poses_lie_at_right_angles),
      cmocka_unit_test(stretched_five_bars_move_least), cmocka_unit_test(flat_five_bars_have_leverage),
      cmocka_unit_test(short_steps_close_all_loops),    cmocka_unit_test(long_rows_of_five_bars_move)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
