/* Numbers as text against the C library: the text reads back to the same bits, and is what printf gives with the fewest
 * digits that do, or shorter. `test_numbers COUNT` tries as many random numbers (scripts/check numbers). */
#include "support/support.h"

#include "base/text.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static long random_count = 200000;

/* The first of %.15g, %.16g, %.17g that reads back; of subnormal numbers from %.1g on. */
static void expected_text(double value, char out[64]) {
  for (int digits = fabs(value) < 1e-290 && value != 0.0 ? 1 : 15; digits <= 17; ++digits) {
    snprintf(out, 64, "%.*g", digits, value);
    if (strtod(out, NULL) == value)
      return;
  }
}

static void check(double value) {
  char text[KM_NUMBER_TEXT], expected[64];
  size_t length = km_number_format(text, value);
  if (isnan(value)) {
    assert_string_equal(text, "nan");
    return;
  }
  expected_text(value, expected);
  /* printf's digits may be more than needed above a power of two: a neighbouring decimal reads back, too. */
  bool shorter = strlen(text) < strlen(expected) && strtod(text, NULL) == value;
  if (strcmp(text, expected) != 0 && !shorter)
    fail_msg("%s instead of %s", text, expected);
  assert_int_equal(length, strlen(text));
}

static void test_special(void **unused) {
  (void)unused;
  static const double values[] = {0.0,
                                  -0.0,
                                  1.0,
                                  -1.5,
                                  0.1,
                                  0.3,
                                  1e15,
                                  1e16,
                                  1e17,
                                  123456789012345.0,
                                  1234567890123456.0,
                                  1e22,
                                  1e23,
                                  9007199254740992.0,
                                  9007199254740993.0,
                                  1e-4,
                                  1e-5,
                                  0.00012345,
                                  5e-324,
                                  DBL_MIN,
                                  DBL_MAX,
                                  2.2250738585072011e-308,
                                  4.35,
                                  0.000123456789012345678,
                                  1e-300,
                                  299792458.0,
                                  6.02214076e23,
                                  HUGE_VAL,
                                  -HUGE_VAL};
  for (size_t i = 0; i < sizeof values / sizeof *values; ++i)
    check(values[i]);
  check(nan(""));
  for (int e = -1074; e < 1024; ++e)
    for (int k = -2; k <= 2; ++k) { /* numbers around powers of two, whose neighbours are at different distances */
      uint64_t bits;
      double value = ldexp(1.0, e);
      memcpy(&bits, &value, sizeof bits);
      bits += (uint64_t)(int64_t)k;
      memcpy(&value, &bits, sizeof bits);
      check(value);
    }
  for (int e = -323; e <= 308; ++e)
    for (int d = 1; d < 10; ++d) {
      char text[32];
      snprintf(text, sizeof text, "%de%d", d, e);
      check(strtod(text, NULL));
    }
}

static void test_random(void **unused) {
  (void)unused;
  randomness r = {2026};
  for (long i = 0; i < random_count; ++i) {
    uint64_t bits = (uint64_t)(uniform(&r, 0.0, 1.0) * 0x1p53) ^ (uint64_t)(uniform(&r, 0.0, 1.0) * 0x1p53) << 11;
    double value;
    memcpy(&value, &bits, sizeof bits);
    check(value);
    check(round(uniform(&r, -1e9, 1e9)) * pow(10.0, -below(&r, 12))); /* decimals with few digits */
  }
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_special), cmocka_unit_test(test_random)};
  if (argc > 1)
    random_count = atol(argv[1]);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
