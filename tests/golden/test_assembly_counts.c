/* Counts of assembly modes from publications. Sources: the models' files. */
#include "support/support.h"

#include "kmech/space.h"
#include "model/model.h"

typedef struct published {
  const char *model;
  int complex_count, real_count, certified;
} published;

/* The count is complete, and each mode is proved and closes the loops. Three postures of Dietmaier's platform are too
 * close to singular ones for a proof in double precision. */
static void published_counts(void **state) {
  (void)state;
  const published rows[] = {{"../tests/cli/models/butterfly", 18, 6, 6},
                            {"../tests/cli/models/general_6r", 16, 16, 16},
                            {"../tests/cli/models/baranov_truss", 126, 76, 76},
                            {"../tests/cli/models/dietmaier", 40, 40, 37}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
    fixture f = fixture_open(rows[i].model);
    km_all_modes modes;
    km_error error = {0};
    const km_all_modes_def def = {.seed = 1};
    if (km_all_modes_find(f.mechanism, f.state, &def, NULL, NULL, &modes, &error))
      fail_msg("%s: %s", rows[i].model, error.text);
    assert_true(modes.is_complete);
    assert_int_equal(modes.complex_solutions, rows[i].complex_count);
    assert_int_equal(modes.count, rows[i].real_count);
    int certified = 0;
    for (int k = 0; k < modes.count; ++k) {
      certified += modes.evidence[k].is_certified;
      assert_at_most(modes.evidence[k].residual, 1e-11);
      assert_int_equal(modes.evidence[k].mobility, 0);
    }
    assert_true(certified >= rows[i].certified);
    km_all_modes_free(&modes);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(published_counts)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
