/* Expressions of the time: values as muParser's, derivatives as closed forms and differences, faults. */
#include "support/support.h"

#include "exchange/json/formula.h"
#include "model/curve/expression.h"

#include <stdio.h>
#include <string.h>

/* The parameter r has the value 2.5. */
static bool value_of_r(const void *context, const char *name, size_t length, double *value) {
  (void)context;
  *value = 2.5;
  return length == 1 && *name == 'r';
}

static const char *const expressions[] = {"t",
                                          "-t^2",
                                          "2^-t",
                                          "2^t^0.5",
                                          "3 - 2 - t",
                                          "12/2/t",
                                          "1e-2*t + .5E1",
                                          "r*sin(2*pi*t + 30*deg)",
                                          "cos(t)^3/(1 + t)",
                                          "tan(0.3*t)*sqrt(t + 1)",
                                          "atan2(t, 2 - r*t)",
                                          "abs(1 - 3*t)",
                                          "min(t, r, 4 - 2*t) + max(t*t, 0.5)",
                                          "(t + 1)^(t - 2)",
                                          "-(-t) - -r",
                                          "t^2*(3 - 2*t)",
                                          "(((t)))",
                                          "max(t)"};

static void values_are_those_of_muparser(void **state) {
  (void)state;
  for (size_t i = 0; i < sizeof expressions / sizeof *expressions; ++i) {
    km_arena arena = {0};
    const km_expression *e = km_expression_compile(expressions[i], value_of_r, NULL, &arena);
    assert_non_null(e);
    for (int k = 1; k < 20; ++k) {
      double t = 0.173 * k, at[3], expected;
      km_formulas *formulas = km_formulas_create(NULL);
      assert_true(km_formulas_define(formulas, "r", 2.5) && km_formulas_define(formulas, "t", t));
      assert_int_equal(km_formulas_evaluate(formulas, expressions[i], &expected, NULL), KM_OK);
      km_expression_at(e, t, at);
      assert_near(at[0], expected, 1e-14 * (1.0 + fabs(expected)));
      km_formulas_free(formulas);
    }
    km_arena_free(&arena);
  }
}

/* Central differences of step h have errors of h²/6 times the third derivative, below 1e3 here away from kinks. */
static void derivatives_are_differences(void **state) {
  (void)state;
  const double h = 1e-5;
  for (size_t i = 0; i < sizeof expressions / sizeof *expressions; ++i) {
    km_arena arena = {0};
    const km_expression *e = km_expression_compile(expressions[i], value_of_r, NULL, &arena);
    for (int k = 1; k < 20; ++k) {
      double t = 0.173 * k + 0.01, at[3], before[3], after[3];
      km_expression_at(e, t, at);
      km_expression_at(e, t - h, before);
      km_expression_at(e, t + h, after);
      for (int d = 0; d < 2; ++d)
        assert_near((after[d] - before[d]) / (2.0 * h), at[d + 1], 1e-7 * (1.0 + fabs(at[1]) + fabs(at[2])));
    }
    km_arena_free(&arena);
  }
}

/* sin(w t)^2: sin², w sin 2wt, 2w² cos 2wt; t^2 at 0, where a power's logarithm has no value. */
static void derivatives_are_closed_forms(void **state) {
  (void)state;
  km_arena arena = {0};
  const km_expression *e = km_expression_compile("sin(3*t)^2", NULL, NULL, &arena);
  double at[3];
  for (int k = -5; k < 20; ++k) {
    double t = 0.31 * k;
    km_expression_at(e, t, at);
    assert_near(at[0], sin(3.0 * t) * sin(3.0 * t), 1e-15);
    assert_near(at[1], 3.0 * sin(6.0 * t), 1e-14);
    assert_near(at[2], 18.0 * cos(6.0 * t), 1e-13);
  }
  e = km_expression_compile("5 + t^2 + t^1 + t^0", NULL, NULL, &arena);
  km_expression_at(e, 0.0, at);
  assert_near(at[0], 6.0, 0.0);
  assert_near(at[1], 1.0, 0.0);
  assert_near(at[2], 2.0, 0.0);
  km_arena_free(&arena);
}

static void faults_are_refused(void **state) {
  (void)state;
  static const char *const faults[] = {"",          "t +",      "(t",  "t)",     "q",    "sin t",
                                       "sin(t, t)", "atan2(t)", "2 t", "t ** 2", "t, t", "max()"};
  km_arena arena = {0};
  for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i)
    assert_null(km_expression_compile(faults[i], value_of_r, NULL, &arena));
  char text[KM_LONGEST_EXPRESSION + 2];
  memset(text, '(', sizeof text);
  text[KM_LONGEST_EXPRESSION + 1] = '\0';
  assert_null(km_expression_compile(text, value_of_r, NULL, &arena));
  text[KM_LONGEST_EXPRESSION] = '\0';
  assert_null(km_expression_compile(text, value_of_r, NULL, &arena));
  km_arena_free(&arena);
}

/* The deepest stack of operands: t+(t+(t+… */
static void deep_nesting_is_evaluated(void **state) {
  (void)state;
  enum { DEPTH = 249 };
  char text[KM_LONGEST_EXPRESSION + 1] = "";
  km_arena arena = {0};
  double at[3];
  for (int i = 0; i < DEPTH; ++i)
    strcat(text, "t+(");
  strcat(text, "t");
  for (int i = 0; i < DEPTH; ++i)
    strcat(text, ")");
  const km_expression *e = km_expression_compile(text, NULL, NULL, &arena);
  assert_non_null(e);
  km_expression_at(e, 2.0, at);
  assert_near(at[0], 2.0 * (DEPTH + 1), 0.0);
  km_arena_free(&arena);
}

static void names_are_found(void **state) {
  (void)state;
  assert_true(km_expression_uses("2*t", "t"));
  assert_false(km_expression_uses("2*tan(x)", "t"));
  assert_false(km_expression_uses("1e5 + at", "t"));
  assert_false(km_expression_uses("3e2", "e2"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(values_are_those_of_muparser), cmocka_unit_test(derivatives_are_differences),
      cmocka_unit_test(derivatives_are_closed_forms), cmocka_unit_test(faults_are_refused),
      cmocka_unit_test(deep_nesting_is_evaluated),    cmocka_unit_test(names_are_found)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
