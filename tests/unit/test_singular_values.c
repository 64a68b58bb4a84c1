/* Singular value decompositions of both methods: A = U S Vᵀ, orthonormal U and V, known values, deficient ranks. */
#include "linalg/dense/singular_values.h"

#include "support/support.h"

#include <math.h>
#include <string.h>

enum { MOST = 80 };

/* Rounding of a product of `size` terms whose sum of magnitudes is of order 1. */
static double rounding(int size) {
  return 20.0 * size * 2.3e-16;
}

static void assert_orthonormal(const double *Q, int length, int count, size_t along, size_t across) {
  for (int a = 0; a < count; ++a)
    for (int b = 0; b <= a; ++b) {
      double sum = 0.0;
      for (int i = 0; i < length; ++i)
        sum += Q[(size_t)i * along + (size_t)a * across] * Q[(size_t)i * along + (size_t)b * across];
      assert_near(sum, a == b ? 1.0 : 0.0, rounding(length));
    }
}

/* Decomposes a random matrix of the rank . */
static void decompose(int rows, int columns, int rank, bool complete, uint64_t seed) {
  static double A[MOST * MOST], copy[MOST * MOST], U[MOST * MOST], Vt[MOST * MOST], s[MOST];
  const int least = rows < columns ? rows : columns;
  const int lead = complete ? columns : least;
  randomness r = {seed};
  memset(A, 0, sizeof A);
  for (int k = 0; k < rank; ++k) {
    double left[MOST], right[MOST];
    for (int i = 0; i < rows; ++i)
      left[i] = uniform(&r, -1.0, 1.0);
    for (int i = 0; i < columns; ++i)
      right[i] = uniform(&r, -1.0, 1.0) / (columns * rows);
    for (int c = 0; c < columns; ++c)
      for (int i = 0; i < rows; ++i)
        A[c * rows + i] += left[i] * right[c];
  }
  memcpy(copy, A, sizeof A);
  assert_int_equal(km_singular_value_decomposition(rows, columns, A, complete, s, U, Vt, NULL), KM_OK);
  assert_orthonormal(U, rows, complete ? rows : least, 1, (size_t)rows);
  assert_orthonormal(Vt, columns, lead, (size_t)lead, 1);
  for (int k = 0; k < least; ++k) {
    assert_true(s[k] >= 0.0 && (k == 0 || s[k] <= s[k - 1]));
    if (k >= rank)
      assert_near(s[k], 0.0, rounding(rows + columns) * s[0]);
  }
  for (int c = 0; c < columns; ++c)
    for (int i = 0; i < rows; ++i) {
      double sum = 0.0;
      for (int k = 0; k < least; ++k)
        sum += U[k * rows + i] * s[k] * Vt[c * lead + k];
      assert_near(sum, copy[c * rows + i], rounding(rows + columns) * fmax(s[0], 1e-300));
    }
}

static void factors_multiply_to_the_matrix(void **state) {
  (void)state;
  static const int sizes[][2] = {{1, 1},  {1, 7},   {7, 1},   {6, 6},   {12, 5},
                                 {5, 12}, {40, 30}, {64, 64}, {70, 20}, {30, 80}};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    const int rows = sizes[i][0], columns = sizes[i][1], least = rows < columns ? rows : columns;
    for (int complete = 0; complete < 2; ++complete) {
      decompose(rows, columns, least, complete, 10 * i + 1);
      decompose(rows, columns, least / 2, complete, 10 * i + 2);
      decompose(rows, columns, 0, complete, 10 * i + 3);
    }
  }
}

/* [3 0; 4 5]: singular values √45 and √5. */
static void known_values(void **state) {
  (void)state;
  double A[4] = {3, 4, 0, 5}, s[2], U[4], Vt[4];
  assert_int_equal(km_singular_value_decomposition(2, 2, A, true, s, U, Vt, NULL), KM_OK);
  assert_near(s[0], sqrt(45.0), 1e-14);
  assert_near(s[1], sqrt(5.0), 1e-14);
}

static void numbers_that_are_not_finite(void **state) {
  (void)state;
  double A[4] = {3, 4, NAN, 5}, s[2], U[4], Vt[4];
  km_error error;
  assert_int_equal(km_singular_value_decomposition(2, 2, A, true, s, U, Vt, &error), KM_DIVERGED);
  assert_non_null(strstr(error.text, "isn't finite"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(factors_multiply_to_the_matrix),
      cmocka_unit_test(known_values),
      cmocka_unit_test(numbers_that_are_not_finite),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
