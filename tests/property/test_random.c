/* The laws on random mechanisms: any topology, any joint types, any senses, closed by construction. */
#include "support/balance.h"
#include "support/laws.h"
#include "support/random_mechanism.h"

static void on_random_mechanisms(law check, bool gears) {
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    randomness r = {seed};
    char *text = random_mechanism(&r, gears);
    fixture f = fixture_read(text);
    km_free(text);
    for (int c = 0; c < f.model->coordinate_count; ++c) /* it was closed, so assembly had nothing to do */
      assert_near(f.state->q[c], f.mechanism->start[c], 1e-9);
    if (f.mechanism->coordinate_count)
      go_somewhere(&f, &r);
    if (f.mechanism->coordinate_count)
      check(&f, &r);
    fixture_close(&f);
  }
}

static void jacobian(void **state) {
  (void)state;
  on_random_mechanisms(law_jacobian, false);
}
static void slopes(void **state) {
  (void)state;
  on_random_mechanisms(law_slopes, true);
}
static void null_space(void **state) {
  (void)state;
  on_random_mechanisms(law_null_space, false);
}
static void numbers(void **state) {
  (void)state;
  on_random_mechanisms(law_numbers, false);
}
static void forced(void **state) {
  (void)state;
  on_random_mechanisms(law_forced, false);
}
static int judged;
static void count_twists(fixture *f, randomness *r) {
  judged += judge_twists(f, r) > 0;
}
static void twists(void **state) {
  (void)state;
  judged = 0;
  on_random_mechanisms(count_twists, false);
  assert_true(judged >= 140); /* 150 cases; the others have no moving body */
}

static void equilibrium(void **state) {
  (void)state;
  on_random_mechanisms(law_equilibrium, true);
}
static void transmitted(void **state) {
  (void)state;
  on_random_mechanisms(law_transmitted, true);
}
static void least_norm(void **state) {
  (void)state;
  on_random_mechanisms(law_least_norm, true);
}
static void virtual_work(void **state) {
  (void)state;
  on_random_mechanisms(law_virtual_work, true);
}
static void reactions(void **state) {
  (void)state;
  on_random_mechanisms(law_reactions, true);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(jacobian, "The loops' Jacobian is the derivative of their error, on 150 random mechanisms",
                 "central differences over 1e-5 err by 1e-10 times third derivatives, and by 1e-16/1e-5"),
      cmocka_unit_test(slopes),
      claim_test(null_space, "J N = 0 for all six rows of every loop, on 150 random mechanisms",
                 "rounding of sums of products, 1e-12 of the largest column"),
      claim_test(
          numbers,
          "Mobility numbers and ranks are those of LAPACK's singular value decomposition, on 150 random mechanisms",
          "rounding of both over the smallest singular value that is kept"),
      claim_test(forced,
                 "Mobility numbers are the same with another column forced independent, on 150 random mechanisms",
                 "rounding over the smallest pivot"),
      claim_test(twists, "Twists of bodies are derivatives of their poses, on 150 random mechanisms",
                 "three times what a central difference errs by, and rounding over the step"),
      claim_test(equilibrium, "Force and moment on every body add up to nothing, on 150 random mechanisms with gears",
                 "rounding: 1e-10 of the largest force, or of its moment"),
      claim_test(transmitted,
                 "A joint's reaction has the actuator's force along the joint's motion, on 150 random mechanisms",
                 "rounding: 1e-10 of the largest force or moment"),
      claim_test(least_norm, "Least-norm forces lie in the space of motions, on 150 random mechanisms",
                 "rounding of the sums"),
      claim_test(virtual_work,
                 "Loads, springs and actuators have no power in any free motion, on 150 random mechanisms",
                 "rounding: 1e-10 of the powers that cancel"),
      claim_test(reactions,
                 "Reactions are LAPACK's least-norm solution of all equations of all bodies, on 150 random mechanisms",
                 "1e-8 of the largest force: rounding over the smallest singular value")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
