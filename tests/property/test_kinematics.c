/* Laws that hold at every pose of every model. */
#include "support/laws.h"

#include "kinematics/loop_equations.h"

#include <math.h>

enum { POSES = 12 };

static void at_random_poses(law check) {
  for (const char *const *name = all_models; *name; ++name) {
    randomness r = {(uint64_t)(name - all_models) + 1};
    for (int i = 0; i < POSES; ++i) {
      fixture f = fixture_open(*name);
      go_somewhere(&f, &r);
      check(&f, &r);
      fixture_close(&f);
    }
  }
}

static void jacobian_is_the_derivative(void **state) {
  (void)state;
  at_random_poses(law_jacobian);
}
static void null_space_is_null(void **state) {
  (void)state;
  at_random_poses(law_null_space);
}
static void numbers_equal_those_of_the_svd(void **state) {
  (void)state;
  at_random_poses(law_numbers);
}
static void numbers_belong_to_the_space(void **state) {
  (void)state;
  at_random_poses(law_forced);
}
/* A loop of few rows and many motions, where what a step has along the rows is less work than what it has along the
 * motions. */
static void more_motions_than_rows(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"a\"}, {\"name\": \"b\"}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"float\", \"body_frame_pairs\": [\"fixed\", \"a\"]},"
      "{\"name\": \"B\", \"type\": \"float\", \"body_frame_pairs\": [\"a\", \"b\"], "
      "\"initial_displacement\": [0.3, 0.4, 0.5, 0.6, 0.7, 0.8]},"
      "{\"name\": \"C\", \"type\": \"spherical\", \"body_frame_pairs\": [\"b\", \"fixed\"]}]}]}");
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    randomness r = {seed};
    law_forced(&f, &r);
  }
  fixture_close(&f);
}
static void twists_are_derivatives(void **state) {
  (void)state;
  at_random_poses(law_twists);
}

/* q1 - 2 q2 = 0, opened by δ: the row is over its largest ratio, and the misfit is the root mean square of six. */
static void open_couplings_are_told_by_size(void **state) {
  (void)state;
  fixture f = fixture_read("{\"assemblies\": [{\"name\": \"gears\", \"bodies\": [{\"name\": \"a\"}, {\"name\": \"b\"}],"
                           "\"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"a\"]},"
                           "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}],"
                           "\"couplings\": [{\"name\": \"mesh\", \"joints\": [\"A\", \"B\"], \"ratios\": [1, -2]}]}],"
                           "\"model_parameters\": {\"version\": \"1.1\"}}");
  const km_substructure *sub = &f.mechanism->substructures[0];
  for (int k = -4; k <= 4; ++k) {
    double delta = 0.05 * k, values[2] = {0.4 + delta, 0.2};
    int worst = 7;
    km_error error;
    assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, values, &error), KM_OK);
    km_loops_update(f.mechanism, f.state, sub);
    assert_near(km_loops_worst(f.mechanism, f.state, sub, &worst), fabs(delta) / 2.0 / sqrt(6.0), 1e-15);
    assert_int_equal(worst, k ? -1 : worst);
  }
  fixture_close(&f);
}

/* A slide between a hinge and a ball, along a frame that is turned by less than the diagonal of a rotation shows:
 * the hinge turns it back. */
static void small_turns_of_frames_count(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"fixed\": {\"frames\": [{\"name\": \"far\", \"T\": [1, 0, 0]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "[{\"name\": \"b\", \"frames\": [{\"name\": \"turned\", \"R\": [[1, -5e-9, 0], [5e-9, 1, 0], [0, 0, 1]]}]}, {\"name\": "
      "\"c\"}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}, {\"name\": \"S\", "
      "\"type\": \"Tx\", \"body_frame_pairs\": [[\"b\", \"turned\"], [\"c\"]], \"initial_displacement\": 1}, {\"name\": \"C\", "
      "\"type\": \"spherical\", \"body_frame_pairs\": [[\"fixed\", \"far\"], [\"c\"]]}]}]}");
  assert_near(f.state->q[0], -5e-9, 1e-15);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(jacobian_is_the_derivative,
                 "The loops' Jacobian is the derivative of their error, at 12 random poses of every model",
                 "central differences over 1e-5 err by 1e-10 times third derivatives, and by 1e-16/1e-5"),
      claim_test(null_space_is_null, "J N = 0 for all six rows of every loop, at random poses of every model",
                 "rounding of sums of products, 1e-12 of the largest column"),
      claim_test(
          numbers_equal_those_of_the_svd,
          "Mobility numbers and ranks are those of LAPACK's singular value decomposition; the numbers add up to the mobility",
          "rounding of both over the smallest singular value that is kept"),
      claim_test(numbers_belong_to_the_space, "Mobility numbers are the same with another column forced independent",
                 "rounding over the smallest pivot"),
      claim_test(
          twists_are_derivatives, "Twists of bodies are derivatives of their poses, at random poses of every model",
          "three times what a central difference errs by, told by its change as the step doubles, and rounding over the step"),
      cmocka_unit_test(more_motions_than_rows),
      cmocka_unit_test(open_couplings_are_told_by_size),
      cmocka_unit_test(small_turns_of_frames_count),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
