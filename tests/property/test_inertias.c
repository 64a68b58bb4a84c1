/* Validity of inertias. */
#include "support/motion_families.h"
#include "support/support.h"

#include <string.h>

#include "model/geometry/mass_properties.h"

static void random_inertias(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 3000; ++seed)
    assert_true(family_inertia(seed));
}

static void known_moments(void **state) {
  (void)state;
  static const struct {
    double I[6], moments[3];
  } cases[] = {{{0.001, 0.001, 0.001, 0.001, 0.001, 0.001}, {0, 0, 0.003}},
               {{0, 0, 0, 0, 0, 2.4e-35}, {-2.4e-35, 0, 2.4e-35}},
               {{1, 1, 1, 2, 0, 0}, {-1, 1, 3}},
               {{0, 0, 0, 0, 0, 0}, {0, 0, 0}},
               {{1e300, 2e300, 3e300, 0, 0, 0}, {1e300, 2e300, 3e300}}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    double found[3];
    km_principal_moments(cases[i].I, found);
    for (int k = 0; k < 3; ++k)
      assert_near(found[k], cases[i].moments[k], 1e-15 * cases[i].moments[2]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(random_inertias), cmocka_unit_test(known_moments)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
