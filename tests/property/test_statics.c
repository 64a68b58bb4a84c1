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
  const struct CMUnitTest tests[] = {cmocka_unit_test(equilibrium), cmocka_unit_test(transmitted),
                                     cmocka_unit_test(virtual_work), cmocka_unit_test(least_norm),
                                     cmocka_unit_test(reactions)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
