/* Laws of the equations of motion, on random mechanisms. */
#include "support/moving.h"
#include "support/random_mechanism.h"

#include <stdlib.h>

/* A random mechanism with masses and rates, assembled; false where the generator made none. */
static bool any_mechanism(uint64_t seed, moving *out, randomness *r) {
  *r = (randomness){seed};
  char *text = random_mechanism(r, true);
  fixture f;
  km_error error;
  bool good = fixture_try(text, &f, &error) == KM_OK;
  free(text);
  if (!good) {
    fixture_close(&f);
    return false;
  }
  give_masses(f.model, r);
  *out = moving_of(f);
  give_rates(out, r);
  return true;
}

/* d'Alembert's principle by momenta along the motion, which no part of the equations of motion computes. Central
 * differences over 1e-5 err by 1e-10 times third derivatives, and by 1e-16 / 1e-5. */
static void test_dalembert(void **data) {
  (void)data;
  int judged = 0;
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    moving m;
    randomness r;
    km_error error = {0};
    if (!any_mechanism(seed, &m, &r))
      continue;
    assert_int_equal(km_dynamics_accelerate(m.dynamics, m.f.state, &error), KM_OK);
    km_poses_update(m.f.mechanism, m.f.state);
    assert_near(dalembert(&m, 1e-5), 0.0, 1e-7);
    judged++;
    moving_close(&m);
  }
  assert_true(judged > 250);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(test_dalembert,
                 "Accelerations satisfy d'Alembert's principle by momenta along the motion, on 300 random mechanisms",
                 "central differences over 1e-5 err by 1e-10 times third derivatives, and by 1e-16/1e-5")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
