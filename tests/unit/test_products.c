/* Products of a matrix's rows are those of A Aᵀ, in any order of the rows and either triangle. */
#include "linalg/sparse/row_products.h"
#include "support/matrices.h"

#include <string.h>

enum { SIZE = 30 };

static int start[SIZE + 1], row[SIZE * SIZE];
static double value[SIZE * SIZE], A[SIZE][SIZE];
static long place[SIZE];

/* A random pattern, some rows of it empty, and a random order. */
static void fill_pattern(int rows, int columns) {
  int entries = 0;
  memset(A, 0, sizeof A);
  for (int c = 0; c < columns; ++c) {
    start[c] = entries;
    for (int r = 0; r < rows; ++r)
      if (r % 7 != 3 && index_below(4) == 0) {
        row[entries] = r;
        A[r][c] = value[entries++] = any();
      }
  }
  start[columns] = entries;
  for (int r = 0; r < rows; ++r) {
    int other = index_below(r + 1);
    place[r] = place[other];
    place[other] = r;
  }
}

/* The rows that aren't used lose their entries. */
static void leave_out(int columns, const bool *used) {
  for (int c = 0; c < columns; ++c)
    for (int i = start[c]; i < start[c + 1]; ++i)
      value[i] = A[row[i]][c] = used[row[i]] ? A[row[i]][c] : 0.0;
}

static double product(int a, int b, int columns, const bool *used) {
  double sum = a == b && !used[a] ? 1.0 : 0.0;
  for (int c = 0; c < columns; ++c)
    sum += A[a][c] * A[b][c];
  return sum;
}

static void products_of_rows(void **state) {
  (void)state;
  for (int i = 0; i < 200; ++i) {
    int rows = 1 + index_below(SIZE), columns = 1 + index_below(SIZE);
    bool used[SIZE], upper = i % 2;
    double found[SIZE][SIZE] = {{0.0}};
    km_row_products p;
    for (int r = 0; r < rows; ++r)
      used[r] = index_below(5) > 0;
    fill_pattern(rows, columns);
    leave_out(columns, used);
    assert_true(km_row_products_create(rows, columns, start, row, place, upper, &p));
    for (int pass = 0; pass < 2; ++pass) /* nothing is left of the pass before */
      km_row_products_compute(&p, value, used);
    for (int k = 0; k < rows; ++k)
      for (long n = p.start[k]; n < p.start[k + 1]; ++n) {
        assert_true(n == p.start[k] || p.row[n] > p.row[n - 1]);
        found[p.row[n]][k] = p.value[n];
      }
    for (int a = 0; a < rows; ++a)
      for (int b = 0; b < rows; ++b) {
        bool kept = upper ? place[a] <= place[b] : place[a] >= place[b];
        assert_near(found[place[a]][place[b]], kept ? product(a, b, columns, used) : 0.0, 1e-14);
      }
    km_row_products_free(&p);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(products_of_rows)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
