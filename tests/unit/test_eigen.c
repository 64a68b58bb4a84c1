/* Eigenvalues of random matrices of every small size keep A v = λ v, and come in pairs; what isn't finite is
 * refused. */
#include "linalg/dense/eigenvalues.h"
#include "support/support.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MOST = 12 };

/* |A v − λ v| of one eigenvector; dgeev errs by a few times n ε |A|. */
static void check_vector(int n, const double *A, const double *re, const double *im, double l_re, double l_im) {
  double size = 0.0;
  for (int i = 0; i < n * n; ++i)
    size = hypot(size, A[i]);
  for (int r = 0; r < n; ++r) {
    double left_re = -(l_re * re[r] - l_im * im[r]), left_im = -(l_re * im[r] + l_im * re[r]);
    for (int c = 0; c < n; ++c) {
      left_re += A[c * n + r] * re[c];
      left_im += A[c * n + r] * im[c];
    }
    assert_near(left_re, 0.0, 20.0 * n * DBL_EPSILON * size);
    assert_near(left_im, 0.0, 20.0 * n * DBL_EPSILON * size);
  }
}

static randomness chance = {17};

static void check_matrix(int n) {
  static const double zero[MOST];
  double A[MOST * MOST], spoilt[MOST * MOST], re[MOST], im[MOST], V[MOST * MOST], trace = 0.0;
  for (int i = 0; i < n * n; ++i)
    spoilt[i] = A[i] = uniform(&chance, -1.0, 1.0);
  assert_int_equal(km_eigen(n, spoilt, re, im, NULL, V, NULL), KM_OK);
  for (int k = 0; k < n; ++k) {
    trace += A[k * n + k] - re[k];
    if (im[k] > 0.0) {
      assert_true(k + 1 < n && re[k + 1] == re[k] && im[k + 1] == -im[k]);
      check_vector(n, A, V + k * n, V + (k + 1) * n, re[k], im[k]);
    } else if (im[k] == 0.0) {
      check_vector(n, A, V + k * n, zero, re[k], 0.0);
    }
  }
  assert_near(trace, 0.0, 20.0 * n * n * DBL_EPSILON);
}

static void random_matrices(void **state) {
  (void)state;
  for (int n = 1; n <= MOST; ++n)
    for (int i = 0; i < 20; ++i)
      check_matrix(n);
}

/* [0 1; −4 0] swings with 2: its numbers are known. */
static void known_pair(void **state) {
  (void)state;
  double A[] = {0.0, -4.0, 1.0, 0.0}, re[2], im[2], V[4];
  assert_int_equal(km_eigen(2, A, re, im, NULL, V, NULL), KM_OK);
  assert_near(re[0], 0.0, 1e-15);
  assert_near(im[0], 2.0, 1e-15);
  assert_near(im[1], -2.0, 1e-15);
}

static void not_finite(void **state) {
  (void)state;
  const double wrong[] = {(double)NAN, HUGE_VAL, -HUGE_VAL};
  for (int i = 0; i < 3; ++i) {
    double A[] = {1.0, 0.0, wrong[i], 1.0}, re[2], im[2], V[4];
    km_error error = {0};
    assert_int_equal(km_eigen(2, A, re, im, NULL, V, &error), KM_DIVERGED);
    assert_non_null(strstr(error.text, "isn't finite"));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(random_matrices, "Eigenvalues and vectors satisfy A x = λ x, random matrices", "rounding of sums"),
      cmocka_unit_test(known_pair),
      cmocka_unit_test(not_finite),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
