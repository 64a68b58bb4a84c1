/* Properties of the partition on random matrices of every small size and some larger ones. All of it by the dense
 * engines and by the sparse one. */
#include "support/matrices.h"

#include <math.h>
#include <string.h>

static void every_size(void **state) {
  (void)state;
  for (int rows = 1; rows <= SMALL; ++rows)
    for (int columns = 1; columns <= SMALL; ++columns)
      for (int rank = 0; rank <= least(rows, columns); ++rank) {
        fill(rows, columns, rank);
        reserve();
        run_svd();
        factor(f.p);
        assert_int_equal(f.svd_rank, rank);
        check_all(f.p, 1e-10);
        check_evidence(f.p);
      }
}

static void large_ones(void **state) {
  (void)state;
  static const int sizes[][3] = {{13, 12, 12}, {12, 64, 12}, {12, 65, 11}, {30, 20, 15}, {36, 42, 30}, {80, 80, 77}};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    fill(sizes[i][0], sizes[i][1], sizes[i][2]);
    reserve();
    run_svd();
    factor(f.p);
    check_all(f.p, 1e-9);
    check_evidence(f.p);
    perturb(1e-4);
    run_svd();
    assert_true(km_factor_refactor(f.p, f.J, f.options.basis));
    check_all(f.p, 1e-9);
  }
}

/* A forced column stays independent exactly where the others have the whole rank. */
static void forced_columns(void **state) {
  (void)state;
  for (int i = 0; i < 3000; ++i) {
    int rows = 1 + index_below(SMALL), columns = 1 + index_below(SMALL);
    fill(rows, columns, 1 + index_below(least(rows, columns)));
    int count = 1 + index_below(3);
    for (int k = 0; k < count; ++k)
      f.forced[index_below(columns)] = true;
    reserve();
    run_svd();
    factor(f.p);
    km_factor_compute(f.q, f.J, rows, columns, &(km_factor_options){.tolerance = 1e-9});
    assert_int_equal(f.p->rank, f.q->rank);
    if (f.p->max_b < 1e3)
      check_all(f.p, 1e-9);
    static double others[MOST * MOST]; /* columns that aren't forced */
    int n = 0;
    for (int c = 0; c < columns; ++c)
      if (!f.forced[c])
        memcpy(others + rows * n++, f.J + rows * c, (size_t)rows * sizeof(double));
    reserve_one(&f.q, rows, n);
    km_factor_compute(f.q, others, rows, n, &(km_factor_options){.tolerance = 1e-9});
    assert_int_equal(f.p->forced_dependent, f.q->rank < f.p->rank);
    int behind = columns;
    while (behind > f.p->rank && f.forced[f.p->column[behind - 1]])
      --behind;
    for (int k = f.p->rank; k < behind; ++k)
      assert_false(f.forced[f.p->column[k]]); /* the forced ones come last */
    f.options.forced_never_pivot = true;      /* then they are no pivots at all */
    factor(f.p);
    assert_int_equal(f.p->rank, f.q->rank);
    assert_false(f.p->forced_dependent);
    for (int k = 0; k < f.p->rank; ++k)
      assert_false(f.forced[f.p->column[k]]);
  }
}

/* Refactorisation of other values gives the result of a new search; of equal values, equal bits. */
static void kept_pivots(void **state) {
  (void)state;
  int accepted = 0;
  for (int i = 0; i < 3000; ++i) {
    int rows = 1 + index_below(SMALL), columns = 1 + index_below(SMALL);
    fill(rows, columns, 1 + index_below(least(rows, columns)));
    if (i % 3 == 0)
      f.forced[index_below(columns)] = true;
    reserve();
    factor(f.p);
    factor(f.q);
    assert_true(km_factor_refactor(f.p, f.J, f.options.basis));
    for (int k = 0; k < km_factor_freedom(f.p); ++k) {
      const double *b = km_factor_b(f.p, k), *other = km_factor_b(f.q, k);
      for (int n = 0; n < f.p->rank; ++n)
        assert_true(b[n] == other[n]);
    }
    perturb(1e-3);
    run_svd();
    if (!km_factor_refactor(f.p, f.J, f.options.basis))
      continue;
    ++accepted;
    assert_int_equal(f.p->search_count, 1);
    factor(f.q);
    assert_int_equal(f.q->search_count, 2);
    assert_int_equal(f.p->rank, f.q->rank);
    if (f.p->max_b < 1e3)
      check_all(f.p, 1e-9);
  }
  assert_true(accepted > 2500);
}

/* Invalid pivots are refused: |B| grown past twice its value, a vanishing pivot, a smaller rank. */
static void refused_pivots(void **state) {
  (void)state;
  double J[] = {2.0, 0.0, 0.0, 1.0, 0.5, 0.5};
  f.rows = 2;
  f.columns = 3;
  reserve();
  km_factor_compute(f.p, J, 2, 3, &(km_factor_options){.tolerance = 1e-9});
  assert_int_equal(f.p->rank, 2);
  assert_true(km_factor_refactor(f.p, J, f.options.basis));
  J[5] = 1.9;
  assert_true(km_factor_refactor(f.p, J, f.options.basis));
  J[5] = 2.1;
  assert_false(km_factor_refactor(f.p, J, f.options.basis));
  J[3] = 0.0;
  assert_false(km_factor_refactor(f.p, J, f.options.basis));
  J[3] = 0.01, J[5] = 0.005; /* B as before, but the pivot has shrunk */
  assert_false(km_factor_refactor(f.p, J, f.options.basis));
  double square[] = {2.0, 0.0, 0.0, 1.0}; /* no freedom left: no B to look at */
  reserve_one(&f.p, 2, 2);
  km_factor_compute(f.p, square, 2, 2, &(km_factor_options){.tolerance = 1e-9});
  square[3] = 0.0;
  assert_false(km_factor_refactor(f.p, square, f.options.basis));
}

static void not_finite(void **state) {
  (void)state;
  static const double bad[] = {(double)NAN, HUGE_VAL, -HUGE_VAL, -(double)NAN};
  for (int i = 0; i < 4000; ++i) {
    int rows = 1 + index_below(SMALL + 4), columns = 1 + index_below(SMALL);
    fill(rows, columns, index_below(least(rows, columns) + 1));
    f.forced[index_below(columns)] = i % 2;
    reserve();
    factor(f.p);
    int count = i % 5 ? 1 + index_below(4) : rows * columns;
    for (int k = 0; k < count; ++k)
      f.J[i % 5 ? index_below(rows * columns) : k] = bad[i % 4];
    assert_false(km_factor_refactor(f.p, f.J, f.options.basis));
    factor(f.p);
    assert_in_range(f.p->rank, 0, least(rows, columns));
    check_permutation(f.p->row, rows);
    check_permutation(f.p->column, columns);
    assert_false(km_factor_refactor(f.p, f.J, f.options.basis));
  }
}

/* Entries of very different sizes, denormal ones and zeros only. */
static void extreme_sizes(void **state) {
  (void)state;
  for (int i = 0; i < 600; ++i) {
    int rows = 1 + index_below(SMALL), columns = 1 + index_below(SMALL);
    fill(rows, columns, least(rows, columns));
    double factor_of = i % 3 == 0 ? 1e-310 : i % 3 == 1 ? 1e150 : 0.0;
    for (int k = 0; k < rows * columns; ++k)
      f.J[k] *= factor_of;
    reserve();
    factor(f.p);
    assert_in_range(f.p->rank, 0, i % 3 == 2 ? 0 : least(rows, columns));
    if (i % 3 == 1)
      assert_int_equal(f.p->rank, least(rows, columns));
  }
}

/* Equal entries: the first column's first row, every time, whatever the size and path. */
static void ties(void **state) {
  (void)state;
  for (int n = 1; n <= SMALL; ++n) {
    fill(n, n, 0);
    for (int c = 0; c < n; ++c)
      for (int r = 0; r < n; ++r)
        f.J[c * n + r] = r == c ? 1.0 : 0.0;
    reserve();
    factor(f.p);
    assert_int_equal(f.p->rank, n);
    for (int i = 0; i < n; ++i) {
      assert_int_equal(f.p->row[i], i);
      assert_int_equal(f.p->column[i], i);
    }
  }
}

/* Entries of nearly equal size are ordered by position if requested, otherwise by size. */
static void near_ties(void **state) {
  (void)state;
  for (int n = 2; n <= SMALL; ++n) {
    fill(n, n, 0);
    for (int c = 0; c < n; ++c)
      for (int r = 0; r < n; ++r)
        f.J[c * n + r] = r == c ? 1.01 + 0.1 * c / n : 0.0;
    reserve();
    for (int nearly = 0; nearly < 2; ++nearly) {
      f.options.ties_by_position = nearly;
      factor(f.p);
      assert_int_equal(f.p->rank, n);
      for (int i = 0; i < n; ++i) {
        int place = nearly ? i : n - 1 - i;
        assert_int_equal(f.p->row[i], place);
        assert_int_equal(f.p->column[i], place);
      }
      assert_true(f.p->first_pivot == f.J[nearly ? 0 : n * n - 1]);
      assert_true(f.p->smallest_pivot == f.J[0]);
    }
  }
}

/* No rows: everything is free. No columns: nothing is. */
static void empty(void **state) {
  (void)state;
  for (int columns = 0; columns <= 3; ++columns)
    for (int rows = columns ? 0 : 3; rows <= (columns ? 0 : 30); rows += 9) {
      fill(rows, columns, 0);
      reserve();
      factor(f.p);
      assert_int_equal(f.p->rank, 0);
      assert_true(km_factor_refactor(f.p, f.J, f.options.basis));
      memcpy(f.Z, km_factor_null_space(f.p, columns), (size_t)(columns * columns) * sizeof *f.Z);
      km_mobility_numbers(f.Z, columns, columns, f.numbers);
      for (int c = 0; c < columns; ++c)
        assert_near(f.numbers[c], 1.0, 1e-15);
    }
}

/* Locked columns are as if they weren't there: the others have the pivots, B and null space of the matrix without them.
 */
static void locked_columns(void **state) {
  (void)state;
  for (int i = 0; i < 400; ++i) {
    bool locked[MOST] = {false};
    int rows = 1 + index_below(i % 4 ? SMALL : 30), columns = 2 + index_below(i % 4 ? SMALL : 30), count = 0;
    fill(rows, columns, index_below(least(rows, columns) + 1));
    for (int c = 0; c < columns; ++c) {
      locked[c] = index_below(3) == 0;
      count += locked[c];
      for (int r = 0; r < rows && locked[c]; ++r)
        f.J[c * rows + r] = 0.0;
    }
    int driver = index_below(columns);
    f.forced[driver] = i % 2 && !locked[driver];
    reserve();
    run_svd(); /* matrix with empty columns: each has a freedom of its own */
    f.options.locked = locked;
    factor(f.p);
    assert_int_equal(f.p->rank, f.svd_rank);
    assert_int_equal(f.p->locked_count, count);
    assert_int_equal(km_factor_freedom(f.p), columns - f.p->rank - count);
    check_permutation(f.p->column, columns);
    check_pivots(f.p);
    for (int k = 0; k < columns; ++k) /* last of all, the driver before them */
      assert_int_equal(locked[f.p->column[k]], k >= columns - count);
    if (f.forced[driver] && !f.p->forced_dependent)
      assert_int_equal(f.p->column[columns - count - 1], driver);
    for (int c = 0; c < columns; ++c)
      f.svd_numbers[c] -= locked[c]; /* a coordinate that moves alone has the number 1 */
    check_null(f.p, 1e-9);
    check_solution(f.p);
    km_factor_copy_pivots(f.q, f.p);
    assert_int_equal(km_factor_freedom(f.q), km_factor_freedom(f.p));
    f.options.locked = NULL;
    factor(f.p);
    assert_int_equal(km_factor_freedom(f.p), columns - f.p->rank);
  }
}

static int use_sparse(void **state) {
  (void)state;
  sparse = true;
  return 0;
}

static int clean(void **state) {
  (void)state;
  km_arena_free(&f.arena);
  return 0;
}

int main(void) {
  const struct CMUnitTest both[] = {
      claim_test(every_size,
                 "Complete pivoting finds LAPACK's rank, numbers and null space, random matrices of every size",
                 "rounding over the smallest pivot"),
      cmocka_unit_test(large_ones),
      cmocka_unit_test(forced_columns),
      cmocka_unit_test(kept_pivots),
      cmocka_unit_test(refused_pivots),
      cmocka_unit_test(not_finite),
      cmocka_unit_test(extreme_sizes),
      cmocka_unit_test(empty),
      cmocka_unit_test(locked_columns),
  };
  const struct CMUnitTest dense[] = {cmocka_unit_test(ties), cmocka_unit_test(near_ties)};
  int failed = cmocka_run_group_tests(both, NULL, clean) + cmocka_run_group_tests(dense, NULL, clean);
  return failed + cmocka_run_group_tests(both, use_sparse, clean);
}
