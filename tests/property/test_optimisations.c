/* Optimisations whose first design fails, and their limit of evaluations. */
#include "support/designs.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A large number with its least value at 0.8; designs below 0.6 fail. */
static km_status steep(void *context, const double *x, double *f, km_error *error) {
  (void)context;
  if (x[0] < 0.6)
    return km_fail(error, KM_NO_RESULT, "it doesn't close");
  f[0] = 1e9 * (1.0 + pow(x[0] - 0.8, 2.0) + pow(x[1] - 0.4, 2.0));
  f[1] = x[0] + x[1];
  return KM_OK;
}

static void optimise(designs *d, const char *algorithm, int evaluations) {
  designs_of_function(d, steep, 2, 2);
  for (int p = 0; p < 2; ++p)
    d->variables[p] = (km_design_variable){p, 0.0, 1.0, nan("")};
  d->optimise = (km_design_optimise){.variables = d->variables,
                                     .variable_count = 2,
                                     .goals = {{"f0", false}},
                                     .goal_count = 1,
                                     .algorithm = algorithm,
                                     .evaluations = evaluations,
                                     .tolerance = 1e-5,
                                     .starts = 1,
                                     .seed = 7};
  d->def.optimise = &d->optimise;
}

/* The middle fails, where the objective's size isn't known yet: the search begins where some design has an answer. */
static void first_designs_may_fail(void **state) {
  (void)state;
  static const char *const algorithms[] = {"cobyla", "bobyqa", "nelder-mead", "subplex", "mma", "direct"};
  for (size_t i = 0; i < sizeof algorithms / sizeof *algorithms; ++i) {
    designs d;
    double x[2];
    optimise(&d, algorithms[i], 1000);
    km_design_study *s = designs_run(&d, NULL, 1);
    int best = km_design_study_best(s);
    assert_true(best >= 0);
    assert_int_equal(km_design_study_values(s, best, x, NULL), KM_OK);
    assert_near(x[0], 0.8, 2e-3);
    assert_near(x[1], 0.4, 2e-3);
    km_design_study_free(s);
  }
}

/* Those beside a point, by which gradients are measured, and those of an inner search count like any others. */
static void no_start_asks_for_more(void **state) {
  (void)state;
  for (int i = 0; km_design_algorithm(i); ++i)
    for (int limits = 0; limits < 2; ++limits) {
      static const int most[] = {1, 2, 20, 150};
      for (size_t k = 0; k < sizeof most / sizeof *most; ++k) {
        designs d;
        optimise(&d, km_design_algorithm(i), most[k]);
        d.figures[1].high = limits ? 1.5 : HUGE_VAL;
        km_design_study *s = designs_run(&d, NULL, 1);
        int asked = km_design_study_designs(s);
        if (asked < 1 || asked > most[k])
          fail_msg("%s asked for %d designs of %d", km_design_algorithm(i), asked, most[k]);
        km_design_study_free(s);
      }
    }
}

static void too_many_are_refused(void **state) {
  (void)state;
  designs d;
  km_design_study *s;
  km_error error;
  optimise(&d, "cobyla", 2000000000);
  d.optimise.starts = 4;
  assert_int_equal(km_design_study_open(&d.def, NULL, false, &s, &error), KM_USAGE);
  assert_string_equal(error.text,
                      "optimise: found 2000000000 evaluations of each of 4 starts; expected at most 1000000000 "
                      "designs in all");
}

static km_status parts(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = x[0];
  return KM_OK;
}

/* Rows of a file may have an order: quantiles and ranks of some of them must not be those of the first ones. */
static void ordered_lists_are_drawn_from(void **state) {
  (void)state;
  enum { COUNT = KM_MAX_RANKED_DESIGNS + 50001 };
  static double list[COUNT];
  designs d;
  km_design_statistics st;
  for (int i = 0; i < COUNT; ++i)
    list[i] = (double)i / (COUNT - 1);
  designs_of_function(&d, parts, 1, 1);
  d.sample = (km_design_sample){.method = KM_SAMPLING_LIST, .count = COUNT, .list = list};
  d.def.sample = &d.sample;
  km_design_study *s = designs_run(&d, NULL, 2);
  assert_int_equal(km_design_study_statistics(s, 0, &st, NULL), KM_OK);
  for (int k = 0; k < KM_DESIGN_QUANTILES; ++k) /* each stands for a piece of 1.25 designs */
    assert_near(st.quantiles[k], km_design_quantile(k), 2.5 / COUNT);
  int last = -1;
  for (int k = 0; k < 400; ++k) {
    int design = km_design_study_representative(s, k, 400);
    assert_true(design > last && design >= (int)((double)k * COUNT / 400) && design < COUNT);
    last = design;
  }
  assert_int_equal(km_design_study_representative(s, 400, 400), -1);
  km_design_study_free(s);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(first_designs_may_fail), cmocka_unit_test(no_start_asks_for_more),
                                     cmocka_unit_test(too_many_are_refused),
                                     cmocka_unit_test(ordered_lists_are_drawn_from)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
