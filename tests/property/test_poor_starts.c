/* Poor starts of Newton's method: least squares close most loops with a small gap, and a branch point is left by a
 * short step along a branch. */
#include "support/random_mechanism.h"
#include "support/support.h"

#include "kinematics/damped_least_squares.h"
#include "kinematics/loop_equations.h"
#include "local/bifurcation.h"

#include <math.h>

static double sum_of_squares(fixture *f, const km_substructure *sub) {
  double sum = 0.0;
  km_loops_update(f->mechanism, f->state, sub);
  for (int r = 0; r < sub->rows; ++r)
    sum += km_state_error(f->state, sub)[r] * km_state_error(f->state, sub)[r];
  return sum;
}

static void least_squares_close_loops(void **state) {
  (void)state;
  int closed = 0, count = 0;
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    randomness r = {seed};
    char *text = random_mechanism(&r, true);
    fixture f = fixture_read(text);
    km_free(text);
    for (int i = 0; i < f.mechanism->topology.substructure_count; ++i) {
      const km_substructure *sub = &f.mechanism->substructures[i];
      double *step = KM_NEW(double, (size_t)sub->columns + 1);
      for (int k = 0; k < sub->columns; ++k)
        step[k] = uniform(&r, -0.2, 0.2);
      km_state_move(f.mechanism, f.state, sub, step);
      double before = sum_of_squares(&f, sub);
      assert_int_equal(km_damped_least_squares(f.mechanism, f.state, i, NULL), KM_OK);
      double after = sum_of_squares(&f, sub);
      assert_true(after <= before + 1e-9);
      closed += after < 1e-12;
      ++count;
      km_free(step);
    }
    fixture_close(&f);
  }
  assert_true(closed >= count - 3);
}

/* The flat parallelogram, a branch point of two motions. */
static void a_branch_point_is_left_by_a_short_step(void **state) {
  (void)state;
  for (int c = 0; c < 4; ++c) {
    fixture f = parallelogram(0.0);
    const km_substructure *sub = &f.mechanism->substructures[0];
    double saved[3 * 4], step[4];
    km_mobility mobility;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_int_equal(mobility.mobility, 2);
    km_state_save(f.state, sub, saved);
    assert_int_equal(km_branch_depart(f.mechanism, f.state, c, 0.0).branch_count, 2);
    km_state_difference(f.state, sub, saved, step);
    double size = 0.0;
    for (int k = 0; k < sub->columns; ++k)
      size = fmax(size, fabs(step[k]));
    assert_true(size > 1e-3 && size < 1e-2);
    km_loops_update(f.mechanism, f.state, sub);
    assert_true(km_loops_residual(f.mechanism, f.state, sub) < 1e-12);
    km_mobility_compute(f.mechanism, f.state, &mobility);
    assert_int_equal(mobility.mobility, 1);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(least_squares_close_loops),
                                     cmocka_unit_test(a_branch_point_is_left_by_a_short_step)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
