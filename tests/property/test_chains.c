/* The laws on substructures of many loops, which the sparse engine factors. */
#include "linalg/factor_private.h"
#include "support/chains.h"
#include "support/laws.h"

#include "model/model.h"

static fixture chain_of(int n) {
  km_text text = {0};
  write_chain(&text, n);
  assert_false(text.failed);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

static void laws_hold(void **state) {
  (void)state;
  static const law laws[] = {law_jacobian, law_slopes, law_null_space, law_numbers, law_forced, law_twists};
  for (int n = 8; n <= 40; n *= 2) {
    randomness r = {(uint64_t)n};
    fixture f = chain_of(n);
    assert_non_null(f.state->factor[0]->sparse);
    for (size_t i = 0; i < sizeof laws / sizeof *laws; ++i)
      laws[i](&f, &r);
    fixture_close(&f);
  }
}

/* Two freedoms, the driver's and the last coupler's, however long the chain: small pivots don't come with length. */
static void length_costs_no_digits(void **state) {
  (void)state;
  for (int n = 10; n <= 1000; n *= 10) {
    fixture f = chain_of(n);
    km_mobility mobility;
    km_substructure_mobility evidence;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    km_substructure_evidence(f.mechanism, f.state, 0, &evidence);
    assert_int_equal(mobility.mobility, 2);
    assert_true(evidence.last_pivot > 0.1);
    fixture_close(&f);
  }
}

/* Every rocker turns as the first one does, over a driven sweep. */
static void rockers_turn_alike(void **state) {
  (void)state;
  fixture f = chain_of(60);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  km_mobility_sweep sweep;
  km_error error;
  plan.coordinate = 0;
  plan.from = 1.0;
  plan.to = 2.5;
  plan.steps = 5;
  assert_int_equal(km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, &error), KM_OK);
  for (int c = 0; c < f.model->coordinate_count; ++c)
    if (f.model->coordinates[c].label[0] == 'P')
      assert_near(km_state_coordinate(f.state, c), 2.5, 1e-9);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(laws_hold),
      cmocka_unit_test(length_costs_no_digits),
      cmocka_unit_test(rockers_turn_alike),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
