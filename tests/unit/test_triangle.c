/* Solutions by the rows of a triangle with few entries. */
#include "linalg/sparse/triangular_solve.h"
#include "support/matrices.h"

#include <string.h>

enum { SIZE = 150, LANES = KM_TRIANGLE_LANES };

static randomness source = {3};
static double dense[SIZE][SIZE]; /* R by rows */
static double value[SIZE * SIZE], b[LANES][SIZE], y[LANES * SIZE];
static long start[SIZE + 1], column[SIZE * SIZE];
static bool row_continues[SIZE], row_leads[SIZE];
static uint64_t marked[SIZE / KM_TRIANGLE_WORD + 1];

/* Blocks of rows with the same columns, and entries that are left out: as Q R leaves them that come out 0. */
static km_triangle open_triangle(int size, double share, double holes) {
  int entries = 0;
  bool has[SIZE] = {false};
  for (int k = 0; k < size; ++k) {
    bool anew = k == 0 || uniform(&source, 0.0, 1.0) < 0.3;
    start[k] = entries;
    for (int c = k; c < size; ++c) {
      has[c] = anew ? uniform(&source, 0.0, 1.0) < share : has[c];
      bool kept = c == k || (has[c] && uniform(&source, 0.0, 1.0) >= holes);
      dense[k][c] = !kept ? 0.0 : c == k ? 2.0 + any() : 0.5 * any();
      if (!kept)
        continue;
      column[entries] = c;
      value[entries++] = dense[k][c];
    }
  }
  start[size] = entries;
  km_triangle R = {start, column, value, row_continues, row_leads, size};
  for (long k = 0; k < size; ++k) {
    row_continues[k] = km_triangle_is_nested(&R, k);
    row_leads[k] = km_triangle_covers_later(&R, k);
  }
  return R;
}

/* |R⁻ᵀ b|², one entry after the other. */
static double dense_square(int size, const double *right) {
  double x[SIZE], sum = 0.0;
  for (int k = 0; k < size; ++k) {
    x[k] = right[k];
    for (int i = 0; i < k; ++i)
      x[k] -= dense[i][k] * x[i];
    x[k] /= dense[k][k];
    sum += x[k] * x[k];
  }
  return sum;
}

/* Repeated right sides, which both register widths leave 0. */
static long put_right_sides(int size) {
  long first = size;
  for (int l = 0; l < LANES; ++l)
    for (long k = 0; k < size; ++k)
      if (b[l][k] != 0.0) {
        y[LANES * k + l] = b[l][k];
        km_triangle_mark(marked, k);
        first = k < first ? k : first;
      }
  return first;
}

static void choose_right_sides(int size) {
  memset(b, 0, sizeof b);
  for (int l = 0; l < LANES; ++l)
    for (int n = 0; n < 3; ++n)
      b[l][index_below(size)] = any();
}

/* By registers of every width, to the last bit. */
static void check_squares(int size, const km_triangle *R) {
  double sum[LANES] = {0.0}, plain[LANES] = {0.0};
  choose_right_sides(size);
  km_triangle_squares(R, put_right_sides(size), y, marked, sum);
  km_triangle_squares_plain(R, put_right_sides(size), y, marked, plain);
  assert_memory_equal(sum, plain, sizeof sum);
  for (int l = 0; l < LANES; ++l)
    assert_near(sum[l] / dense_square(size, b[l]), 1.0, 1e-9);
  for (int i = 0; i < LANES * size; ++i)
    assert_true(y[i] == 0.0);
  for (int word = 0; word <= size / KM_TRIANGLE_WORD; ++word)
    assert_true(marked[word] == 0);
}

/* Whatever entries of a row its first column lacks. */
static void squares_of_any_triangle(void **state) {
  (void)state;
  for (int i = 0; i < 300; ++i) {
    int size = 1 + index_below(SIZE);
    double share = uniform(&source, 0.0, 0.1), holes = i % 3 == 0 ? 0.0 : 0.2;
    km_triangle R = open_triangle(size, share, holes);
    check_squares(size, &R);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(squares_of_any_triangle)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
