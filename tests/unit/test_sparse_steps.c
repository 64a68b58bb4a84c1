/* The sparse engine for steps only, and its choice of dependent rows. */
#include "support/matrices.h"

#include <math.h>
#include <string.h>

enum { ROWS = 60, COLUMNS = 130, REACH = 8 };

static int start[COLUMNS + 1], row[COLUMNS * REACH];
static double values[COLUMNS * REACH], weight[COLUMNS];

/* A band of full rank: row r in columns 2 r … 2 r + REACH - 1; `leading` is added to the first entry of each row. */
static void fill_band(double leading) {
  int entries = 0;
  for (int c = 0; c < COLUMNS; ++c) {
    weight[c] = 0.3 + fabs(any());
    start[c] = entries;
    for (int r = 0; r < ROWS; ++r)
      if (c >= 2 * r && c < 2 * r + REACH) {
        row[entries] = r;
        values[entries++] = any() + (c == 2 * r ? leading : 0.0);
      }
  }
  start[COLUMNS] = entries;
}

static void factor_band(km_factor *p, bool unwatched) {
  km_factor_compute(p, values, ROWS, COLUMNS,
                    &(km_factor_options){.tolerance = 1e-9, .basis = unwatched ? KM_BASIS_ANY : KM_BASIS_SHORT});
}

/* Without independent columns, rank, primary rows and minimum-norm steps are equal; columns requested afterwards are
 * those of a new partition. */
static void equal_steps_for_any_columns(void **state) {
  (void)state;
  double rhs[ROWS], least[COLUMNS], other[COLUMNS];
  int others = 0;
  for (int i = 0; i < 20; ++i) {
    km_arena arena = {0};
    km_normal_equations *kept = NULL;
    fill_band(2.0);
    km_factor *p = km_factor_create_sparse(ROWS, COLUMNS, start, row, weight, &arena);
    km_factor_share_normal_equations(p, &kept);
    km_factor *q = km_factor_create_like(p, &arena);
    factor_band(p, true);
    factor_band(q, false);
    int freedom = km_factor_freedom(p);
    assert_true(freedom > KM_MANY_VECTORS);
    assert_int_equal(p->rank, q->rank);
    others += memcmp(p->column, q->column, sizeof *p->column * COLUMNS) != 0;
    for (int r = 0; r < ROWS; ++r)
      rhs[r] = any();
    assert_true(km_sparse_minimum_norm(p, values, freedom, rhs, least));
    assert_true(km_sparse_minimum_norm(q, values, freedom, rhs, other));
    for (int c = 0; c < COLUMNS; ++c)
      assert_near(least[c], other[c], 1e-12);
    factor_band(p, false);
    assert_memory_equal(p->column, q->column, sizeof *p->column * COLUMNS);
    assert_true(p->max_b == q->max_b);
    km_normal_equations_free(kept);
    km_arena_free(&arena);
  }
  assert_true(others > 5);
}

/* J n = 0 for the short null vectors of a band without dominant entries, where the elimination alone leaves |B| above
 * 1e9. Rounding of J n: REACH entries of at most 1, each with relative rounding times |B|. */
static void short_null_vectors(void **state) {
  (void)state;
  for (int i = 0; i < 20; ++i) {
    km_arena arena = {0};
    double n[COLUMNS], product[ROWS];
    fill_band(0.0);
    km_factor *p = km_factor_create_sparse(ROWS, COLUMNS, start, row, weight, &arena);
    factor_band(p, false);
    assert_true(km_factor_freedom(p) > KM_MANY_VECTORS);
    assert_true(p->max_b <= km_max_good_b);
    for (int k = p->rank; k < COLUMNS; ++k) {
      km_factor_null_vector(p, p->column[k], n);
      memset(product, 0, sizeof product);
      for (int c = 0; c < COLUMNS; ++c)
        for (int e = start[c]; e < start[c + 1]; ++e)
          product[row[e]] += values[e] * n[c];
      for (int r = 0; r < ROWS; ++r)
        assert_near(product[r], 0.0, 1e-12);
    }
    km_arena_free(&arena);
  }
}

/* A row that is the sum of all others but for an entry of that size, which is its distance from them. */
static void fill_sum(int rows, double distance) {
  int entries = 0;
  f.rows = f.columns = rows;
  memset(f.J, 0, sizeof f.J);
  for (int c = 0; c < rows; ++c) {
    f.D[c] = 1.0;
    f.forced[c] = false;
    start[c] = entries;
    if (c + 1 < rows) {
      row[entries++] = c;
      f.J[c * rows + c] = 1.0;
    }
    row[entries++] = rows - 1;
    f.J[c * rows + rows - 1] = c + 1 < rows ? 1.0 : distance;
  }
  start[rows] = entries;
}

/* A row depends on others where it is no further than the tolerance from what they span, as by complete pivoting.
 * The smallest singular value is that distance over the square root of how many they are. */
static void row_near_the_span_of_many(void **state) {
  (void)state;
  for (int i = 0; i < 40; ++i) {
    static const double distance[] = {3e-9, 0.5e-9, 1e-4, 1e-12};
    int rows = 30 + index_below(30);
    fill_sum(rows, distance[i % 4]);
    reserve();
    f.p = km_factor_create_sparse(rows, rows, start, row, f.D, &f.arena);
    f.options = (km_factor_options){.tolerance = 1e-9, .forced = f.forced};
    f.options.basis = i % 8 < 4 ? KM_BASIS_NONE : KM_BASIS_SHORT;
    factor(f.p);
    km_factor_compute(f.q, f.J, rows, rows, &(km_factor_options){.tolerance = 1e-9});
    assert_int_equal(f.q->rank, rows - i % 2);
    assert_int_equal(f.p->rank, f.q->rank);
    f.p->sparse->postpones_small = false;
    memset(f.p->sparse->is_postponed, 0, (size_t)rows * sizeof *f.p->sparse->is_postponed);
    km_sparse_eliminate(f.p, stored(f.p), NULL, 1e-14);
    assert_int_equal(f.p->rank, rows);
    assert_int_equal(km_sparse_hidden_row(f.p, stored(f.p), NULL, 1e-9) >= 0, i % 2);
  }
}

static int clean(void **state) {
  (void)state;
  km_arena_free(&f.arena);
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(equal_steps_for_any_columns),
                                     cmocka_unit_test(short_null_vectors), cmocka_unit_test(row_near_the_span_of_many)};
  return cmocka_run_group_tests(tests, NULL, clean);
}
