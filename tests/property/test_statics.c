/* Balance of forces over all models: virtual work, equilibrium, and an independent solution of all equations at once.
 */
#include "support/balance.h"

#include "model/model.h"

static void on_all_models(void (*law)(fixture *, randomness *)) {
  randomness r = {1};
  for (const char *const *name = all_models; *name; ++name) {
    for (int pose = 0; pose < 3; ++pose) {
      fixture f = fixture_open(*name);
      for (int i = 0; i < pose; ++i)
        go_somewhere(&f, &r);
      law(&f, &r);
      fixture_close(&f);
    }
  }
}

static void equilibrium(void **state) {
  (void)state;
  on_all_models(law_equilibrium);
}
static void transmitted(void **state) {
  (void)state;
  on_all_models(law_transmitted);
}
static void virtual_work(void **state) {
  (void)state;
  on_all_models(law_virtual_work);
}
/* Also with lengths weighed by another characteristic length. */
static void least_norm(void **state) {
  (void)state;
  randomness r = {5};
  on_all_models(law_least_norm);
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    km_model_share_length(f.model, 3.7);
    km_mechanism_free(f.mechanism);
    km_state_free(f.state);
    f = fixture_of(f.model);
    law_least_norm(&f, &r);
    law_virtual_work(&f, &r);
    fixture_close(&f);
  }
}
static void reactions(void **state) {
  (void)state;
  on_all_models(law_reactions);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(equilibrium, "Force and moment on every body add up to nothing, every model under random loads",
                 "rounding: 1e-10 of the largest force, or of its moment"),
      claim_test(transmitted, "A joint's reaction has the actuator's force along the joint's motion, every model",
                 "rounding: 1e-10 of the largest force or moment"),
      claim_test(virtual_work, "Loads, springs and actuators have no power in any free motion, every model",
                 "rounding: 1e-10 of the powers that cancel"),
      claim_test(least_norm, "Least-norm forces lie in the space of motions, also with another characteristic length",
                 "rounding of the sums"),
      claim_test(reactions, "Reactions are LAPACK's least-norm solution of all equations of all bodies, every model",
                 "1e-8 of the largest force: rounding over the smallest singular value")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
