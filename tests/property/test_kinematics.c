/* Laws that hold at every pose of every model. */
#include "support/laws.h"

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
static void twists_are_derivatives(void **state) {
  (void)state;
  at_random_poses(law_twists);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(jacobian_is_the_derivative),     cmocka_unit_test(null_space_is_null),
      cmocka_unit_test(numbers_equal_those_of_the_svd), cmocka_unit_test(numbers_belong_to_the_space),
      cmocka_unit_test(twists_are_derivatives),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
