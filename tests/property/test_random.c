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
  assert_true(judged >= 140); /* of 150; the others have no body that moves */
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
  const struct CMUnitTest tests[] = {cmocka_unit_test(jacobian),     cmocka_unit_test(null_space),
                                     cmocka_unit_test(numbers),      cmocka_unit_test(forced),
                                     cmocka_unit_test(twists),       cmocka_unit_test(equilibrium),
                                     cmocka_unit_test(transmitted),  cmocka_unit_test(least_norm),
                                     cmocka_unit_test(virtual_work), cmocka_unit_test(reactions)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
