/* The sparse engine on patterns with holes. */
#include "support/matrices.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static randomness source = {5};
static int start[MOST + 1], row[MOST * MOST];

static void begin_pattern(int rows, int columns) {
  f.rows = rows;
  f.columns = columns;
  memset(f.J, 0, sizeof f.J);
}

static void begin_column(int c, int entries) {
  f.D[c] = 0.3 + fabs(any());
  f.forced[c] = false;
  start[c] = entries;
}

/* A band with some entries far off, of a rank that is less than full: as a substructure of many loops. */
static void fill_band(int rows, int columns) {
  int entries = 0;
  begin_pattern(rows, columns);
  for (int c = 0; c < columns; ++c) {
    begin_column(c, entries);
    for (int r = 0; r < rows; ++r) {
      bool near = abs(r * columns - c * rows) <= 2 * columns, far = index_below(40) == 0;
      bool twin = c % 10 == 9 && f.J[(c - 1) * rows + r] != 0.0; /* a multiple of the column before */
      if (c % 10 == 9 ? twin : near || far) {
        f.J[c * rows + r] = twin ? -0.7 * f.J[(c - 1) * rows + r] : any();
        row[entries++] = r;
      }
    }
  }
  start[columns] = entries;
}

static void reserve_sparse(void) {
  reserve();
  f.p = km_factor_create_sparse(f.rows, f.columns, start, row, f.D, &f.arena);
  f.options = (km_factor_options){.tolerance = 1e-9, .forced = f.forced};
}

/* Any entries where `has` says so. */
static void open_where(int rows, int columns, bool (*has)(int column, int row)) {
  int entries = 0;
  begin_pattern(rows, columns);
  for (int c = 0; c < columns; ++c) {
    begin_column(c, entries);
    for (int r = 0; r < rows; ++r)
      if (has(c, r)) {
        f.J[c * rows + r] = any();
        row[entries++] = r;
      }
  }
  start[columns] = entries;
  reserve_sparse();
}

/* 20 rows and up to `rows` more; `least` columns and up to `columns` more. */
static void open_band(int rows, int least, int columns) {
  int r = 20 + index_below(rows);
  fill_band(r, least + index_below(columns));
  reserve_sparse();
}

/* At values nearby a copy of the pivots serves as the pivots themselves do, to the last bit, whatever it held
 * before: here single entries. */
static void check_copy(void) {
  static double single[MOST * MOST];
  memset(single, 0, sizeof single);
  for (int c = 0; c < f.columns; ++c)
    single[start[c]] = 1.0;
  f.q = km_factor_create_like(f.p, &f.arena);
  km_factor_compute(f.q, single, f.rows, f.columns, &(km_factor_options){.tolerance = 1e-9});
  km_factor_copy_pivots(f.q, f.p);
  for (int k = 0; k < f.rows * f.columns; ++k)
    f.J[k] *= 1.0 + 1e-7 * any();
  f.q->smallest_pivot = f.p->smallest_pivot;
  f.q->max_b_at_search = f.p->max_b_at_search;
  bool kept = km_factor_refactor(f.p, stored(f.p), f.options.basis);
  assert_int_equal(km_factor_refactor(f.q, stored(f.q), f.options.basis), kept);
  for (int k = 0; k < km_factor_freedom(f.p); ++k) {
    const double *b = km_factor_b(f.p, k), *other = km_factor_b(f.q, k);
    for (int n = 0; n < f.p->rank; ++n)
      assert_true(b[n] == other[n]);
  }
}

/* J x = rhs in rows list[0 … count-1]. */
static void check_rows(const int *list, int count, const double *x, const double *rhs, double tolerance) {
  for (int k = 0; k < count; ++k) {
    double sum = 0.0;
    for (int c = 0; c < f.columns; ++c)
      sum += f.J[c * f.rows + list[k]] * x[c];
    assert_near(sum, rhs[list[k]], tolerance);
  }
}

/* Mobility numbers by the rows alone are those by Z, which is made. */
static void check_numbers(double tolerance) {
  double numbers[MOST], by_rows[MOST];
  int freedom = km_factor_freedom(f.p);
  memcpy(f.Z, km_factor_null_space(f.p, freedom), (size_t)(freedom * f.columns) * sizeof *f.Z);
  km_mobility_numbers(f.Z, f.columns, freedom, numbers);
  assert_true(km_factor_mobility_numbers(f.p, stored(f.p), by_rows));
  for (int c = 0; c < f.columns; ++c)
    assert_near(by_rows[c], numbers[c], tolerance);
}

/* The sparse engine on patterns with holes, against LAPACK's and against the dense one. */
static void against_the_dense_engine(void **state) {
  (void)state;
  for (int i = 0; i < 400; ++i) {
    open_band(50, 20, 60);
    if (i % 2)
      f.forced[index_below(f.columns)] = true;
    run_svd();
    factor(f.p);
    km_factor_compute(f.q, f.J, f.rows, f.columns, &f.options);
    assert_near(f.p->rank, f.q->rank, 0.0);
    assert_int_equal(f.p->forced_dependent, f.q->forced_dependent);
    if (f.p->max_b < 1e3)
      check_all(f.p, 1e-9);
    if (!(i % 2)) /* as small as complete pivoting keeps it, or nearly */
      assert_true(f.p->max_b <= 2.0 * fmax(f.q->max_b, 1.0));
    check_copy();
  }
}

/* One of four. */
static bool is_chosen(int column, int r) {
  (void)column;
  (void)r;
  return index_below(4) == 0;
}

/* Where nearly all fills in, steps go together: rank, null space and solutions are the dense engine's. */
static void much_fill(void **state) {
  (void)state;
  enum { ROWS = 65 };
  int checked = 0;
  for (int i = 0; i < 30; ++i) {
    open_where(ROWS, ROWS + index_below(15), is_chosen);
    run_svd();
    factor(f.p);
    assert_int_equal(f.p->rank, f.svd_rank);
    if (f.p->max_b > 1e3)
      continue;
    check_all(f.p, 1e-9);
    ++checked;
  }
  assert_true(checked > 15);
}

/* Some entries of the pattern are 0 at this pose, and others at the next one. */
static void fill_zeros(double share, bool only_zeros) {
  const km_sparse *s = f.p->sparse;
  for (int c = 0; c < f.columns; ++c)
    for (int i = s->start[c]; i < s->start[c + 1]; ++i) {
      double *entry = &f.J[c * f.rows + s->row[i]];
      bool changes = uniform(&source, 0.0, 1.0) < share;
      if (changes && (!only_zeros || *entry == 0.0))
        *entry = only_zeros ? any() : 0.0;
    }
}

/* J_pd B = J_pi in the primary rows. */
static void check_primary_rows(const km_factor *p) {
  for (int k = p->rank; k < p->columns; ++k) {
    const double *b = km_factor_b(p, k - p->rank);
    for (int i = 0; i < p->rank; ++i) {
      double sum = f.J[p->column[k] * f.rows + p->row[i]];
      for (int n = 0; n < p->rank; ++n)
        sum -= f.J[p->column[n] * f.rows + p->row[i]] * b[n];
      assert_near(sum, 0.0, 1e-10 * (1.0 + p->max_b));
    }
  }
}

/* True if an entry that the singletons assume to be 0 is not. */
static bool singletons_fill(void) {
  const km_sparse *s = f.p->sparse;
  const double *values = stored(f.p);
  bool fills = false;
  for (int i = 0; i < s->singleton_zero_count; ++i)
    fills = fills || values[s->singleton_zero[i]] != 0.0;
  return fills;
}

static void zeros_that_fill(void **state) {
  (void)state;
  int kept = 0, whole = 0, singles = 0;
  for (int i = 0; i < 400; ++i) {
    open_band(50, 20, 60);
    fill_zeros(0.6, false);
    run_svd();
    factor(f.p);
    singles += f.p->sparse->singleton_count;
    assert_near(f.p->rank, f.svd_rank, 0.0);
    if (f.p->max_b < 1e3)
      check_all(f.p, 1e-9);
    check_copy();
    fill_zeros(0.01, true);
    bool fills = singletons_fill();
    if (!km_factor_refactor(f.p, stored(f.p), f.options.basis))
      continue;
    kept += !fills;
    whole += fills;
    if (f.p->max_b < 1e3)
      check_primary_rows(f.p);
  }
  assert_true(kept > 20 && whole > 20 && singles > 2000);
}

/* J n = 0 for every sparse null vector; their number agrees with the singular values. */
static void null_vectors_by_their_entries(void **state) {
  (void)state;
  int column[MOST];
  double value[MOST];
  for (int i = 0; i < 200; ++i) {
    open_band(50, 20, 60);
    fill_zeros(0.5, false);
    run_svd();
    f.options.basis = KM_BASIS_ENTRIES;
    factor(f.p);
    assert_near(km_factor_freedom(f.p), f.columns - f.svd_rank, 0.0);
    for (int k = 0; k < km_factor_freedom(f.p); ++k) {
      int count = km_factor_null_entries(f.p, k, column, value), units = 0;
      double residual[MOST] = {0}, largest = 0.0;
      for (int n = 0; n < count; ++n) {
        largest = fmax(largest, fabs(value[n]));
        units += column[n] == f.p->column[f.p->rank + k] && value[n] == 1.0;
        for (int r = 0; r < f.rows; ++r)
          residual[r] += f.J[column[n] * f.rows + r] * value[n];
      }
      assert_int_equal(units, 1);
      for (int r = 0; r < f.rows && largest < 1e4; ++r)
        assert_near(residual[r], 0.0, 1e-9 * largest);
    }
  }
}

/* Every second partition has a place for its normal equations, and is to make some. */
static km_normal_equations *kept;

static void keep_normal(int i) {
  km_factor_share_normal_equations(f.p, i % 2 ? &kept : NULL);
}

static void free_normal(int i) {
  assert_int_equal(kept != NULL, i % 2);
  km_normal_equations_free(kept);
  kept = NULL;
}

/* A projected step is orthogonal to the null space Z. */
static void steps_without_null_vectors(void **state) {
  (void)state;
  double x[MOST], left[MOST], work[MOST];
  for (int i = 0; i < 100; ++i) {
    open_band(20, 30, 50);
    factor(f.p);
    int freedom = km_factor_freedom(f.p);
    if (freedom == 0 || f.p->max_b > 1e3)
      continue;
    memcpy(f.Z, km_factor_null_space(f.p, freedom), (size_t)(freedom * f.columns) * sizeof *f.Z);
    for (int c = 0; c < f.columns; ++c)
      x[c] = any();
    memcpy(left, x, sizeof left);
    keep_normal(i);
    assert_true(km_sparse_remove_null_space(f.p, stored(f.p), freedom, left, work));
    free_normal(i);
    for (int k = 0; k < freedom; ++k) {
      double along = 0.0;
      for (int c = 0; c < f.columns; ++c)
        along += f.Z[k * f.columns + c] * f.D[c] * x[c];
      for (int c = 0; c < f.columns; ++c)
        x[c] -= along * f.Z[k * f.columns + c] / f.D[c];
    }
    for (int c = 0; c < f.columns; ++c)
      assert_near(left[c], x[c], 1e-10);
  }
}

/* Mobility numbers and least solutions by the rows alone are those by Z. */
static void by_rows_alone(void **state) {
  (void)state;
  double rhs[MOST], x[MOST], least[MOST], work[MOST];
  for (int i = 0; i < 100; ++i) {
    open_band(20, 30, 50);
    factor(f.p);
    int freedom = km_factor_freedom(f.p), rank = f.p->rank;
    if (freedom == 0 || f.p->max_b > 1e3)
      continue;
    check_numbers(1e-10);
    for (int r = 0; r < f.rows; ++r)
      rhs[r] = any();
    km_factor_solve(f.p, rhs, x);
    keep_normal(i);
    assert_true(km_sparse_remove_null_space(f.p, stored(f.p), freedom, x, work));
    f.options.basis = KM_BASIS_NONE;
    factor(f.p);
    assert_int_equal(f.p->rank, rank);
    assert_true(km_sparse_minimum_norm(f.p, stored(f.p), freedom, rhs, least));
    free_normal(i);
    check_rows(f.p->row, rank, least, rhs, 1e-9); /* the primary rows may be others: the solution of these */
    for (int k = 0; k < freedom; ++k) {
      double along = 0.0;
      for (int c = 0; c < f.columns; ++c)
        along += f.Z[k * f.columns + c] * f.D[c] * least[c];
      assert_near(along, 0.0, 1e-9);
    }
  }
}

/* Pairs of rows that differ by no more than `apart`, in a band. */
static void fill_twins(int rows, double apart) {
  enum { REACH = 10 };
  int entries = 0;
  f.rows = rows;
  f.columns = rows + REACH;
  memset(f.J, 0, sizeof f.J);
  for (int c = 0; c < f.columns; ++c) {
    f.D[c] = 0.3 + fabs(any());
    f.forced[c] = false;
    start[c] = entries;
    for (int r = 0; r < rows; ++r) {
      int first = r - r % 2;
      if (c < first || c >= first + REACH)
        continue;
      f.J[c * rows + r] = r > first ? f.J[c * rows + first] + apart * any() : any();
      row[entries++] = r;
    }
  }
  start[f.columns] = entries;
}

/* Normal equations square the condition number: their solutions agree with those by QR to the remaining digits. */
static void rows_that_hardly_differ(void **state) {
  (void)state;
  double rhs[MOST], by_qr[MOST], least[MOST];
  for (int i = 0; i < 80; ++i) {
    double apart = pow(10.0, -i % 8), longest = 0.0;
    fill_twins(20 + 2 * index_below(10), apart);
    reserve_sparse();
    f.options.basis = KM_BASIS_NONE;
    factor(f.p);
    int freedom = km_factor_freedom(f.p);
    assert_int_equal(f.p->rank, f.rows);
    for (int r = 0; r < f.rows; ++r)
      rhs[r] = any();
    assert_true(km_sparse_minimum_norm(f.p, stored(f.p), freedom, rhs, by_qr));
    keep_normal(1);
    assert_true(km_sparse_minimum_norm(f.p, stored(f.p), freedom, rhs, least));
    free_normal(1);
    for (int c = 0; c < f.columns; ++c)
      longest = fmax(longest, fabs(by_qr[c]));
    for (int c = 0; c < f.columns; ++c)
      assert_near(least[c], by_qr[c], 1e-13 / apart * longest);
  }
}

/* Rows with a forced column that is never a pivot, independent or one a sum of two others: rank and refactorisation. */
static void rows_beside_a_forced_column(void **state) {
  (void)state;
  for (int i = 0; i < 60; ++i) {
    bool depends = i % 3 == 0;
    fill_twins(20 + 2 * index_below(10), 1.0);
    for (int c = 0; c < f.columns; ++c) {
      f.forced[c] = c == i % f.columns;
      if (depends) /* the third row and the fourth one have entries wherever the others do, but for two columns */
        f.J[c * f.rows + 3] = c >= 2 && c < 12 ? f.J[c * f.rows + 2] : 0.0;
    }
    reserve_sparse();
    run_svd();
    f.options.basis = KM_BASIS_NONE;
    f.options.forced_never_pivot = true;
    factor(f.p);
    assert_int_equal(f.p->rank, f.rows - depends);
    assert_int_equal(f.svd_rank, f.p->rank);
    assert_int_equal(f.p->column[f.columns - 1], i % f.columns);
    assert_true(depends || (f.p->smallest_pivot > 0.0 && f.p->smallest_pivot <= f.p->scale));
    assert_true(km_factor_refactor(f.p, stored(f.p), f.options.basis));
  }
}

/* Column c has 1 in row c and 2 in the next row: the columns are dependent to 2^-rows, and no pivot shows it.
 * Further columns with entries in first rows, which dominate the dependent combination of rows, make the rows
 * independent; entries in last rows don't. */
static void fill_chain(int rows, int more) {
  int entries = 0;
  f.rows = rows;
  f.columns = rows + more;
  memset(f.J, 0, sizeof f.J);
  for (int c = 0; c < f.columns; ++c) {
    int first = c < rows ? c : index_below(2) ? index_below(5) : rows - 2;
    f.D[c] = 1.0;
    f.forced[c] = false;
    start[c] = entries;
    for (int r = first; r < rows && r < first + 2; ++r) {
      f.J[c * rows + r] = c < rows ? 1.0 + r - first : any();
      row[entries++] = r;
    }
  }
  start[f.columns] = entries;
}

/* Row factorisation has the rank of the singular values, and as many primary rows. */
static void rows_where_no_pivot_tells(void **state) {
  (void)state;
  double rhs[MOST], least[MOST];
  int hidden = 0;
  for (int i = 0; i < 60; ++i) {
    fill_chain(40 + index_below(15), i % 4);
    reserve_sparse();
    run_svd();
    f.options.basis = KM_BASIS_NONE;
    factor(f.p);
    assert_near(f.p->rank, f.svd_rank, 0.0);
    for (int r = 0; r < f.rows; ++r)
      rhs[r] = any();
    keep_normal(i);
    assert_true(km_sparse_minimum_norm(f.p, stored(f.p), km_factor_freedom(f.p), rhs, least));
    free_normal(i);
    double longest = 1.0;
    for (int c = 0; c < f.columns; ++c)
      longest = fmax(longest, fabs(least[c]));
    check_rows(f.p->row, f.p->rank, least, rhs, 1e-13 * longest); /* rounding of what nearly dependent rows need */
    f.p->sparse->postpones_small = false;
    memset(f.p->sparse->is_postponed, 0, (size_t)f.columns * sizeof *f.p->sparse->is_postponed);
    km_sparse_eliminate(f.p, stored(f.p), NULL, 1e-9 * f.p->scale);
    assert_int_equal(km_sparse_hidden_row(f.p, stored(f.p), NULL, 1e-9 * f.p->scale) >= 0, f.svd_rank < f.p->rank);
    hidden += f.svd_rank < f.p->rank;
  }
  assert_true(hidden >= 15);
}

/* The history of a partition has no influence: after factorising by rows, and refactorising nearby values, it has by
 * columns the pivots and B of a new partition, bit by bit. */
static void history_has_no_influence(void **state) {
  (void)state;
  for (int i = 0; i < 100; ++i) {
    open_band(20, 30, 50);
    f.options.basis = KM_BASIS_NONE;
    factor(f.p);
    for (int pass = 0; pass < 2; ++pass) {
      for (int k = 0; k < f.rows * f.columns; ++k)
        f.J[k] *= 1.0 + 1e-3 * any();
      km_factor_refactor(f.p, stored(f.p), f.options.basis);
      for (int r = 0; r < f.rows; ++r)
        assert_true(f.p->sparse->x[r] == 0.0);
    }
    fill_zeros(0.8, false);
    f.options.basis = KM_BASIS_SHORT;
    factor(f.p);
    f.q = km_factor_create_like(f.p, &f.arena);
    factor(f.q);
    assert_int_equal(f.p->rank, f.q->rank);
    assert_memory_equal(f.p->row, f.q->row, (size_t)f.rows * sizeof *f.p->row);
    assert_memory_equal(f.p->column, f.q->column, (size_t)f.columns * sizeof *f.p->column);
    assert_memory_equal(f.p->inverse, f.q->inverse, (size_t)f.p->rank * sizeof *f.p->inverse);
    for (int k = 0; k < km_factor_freedom(f.p); ++k)
      for (int n = 0; n < f.p->rank; ++n)
        assert_true(km_factor_b(f.p, k)[n] == km_factor_b(f.q, k)[n]);
  }
}

/* By columns, of few freedoms and of many; independent columns are then others than those that came last, and B
 * small. */
static void columns_where_no_pivot_tells(void **state) {
  (void)state;
  int chosen = 0;
  for (int i = 0; i < 60; ++i) {
    bool many = i % 2 > 0;
    fill_chain(many ? 30 : 40 + index_below(15), many ? KM_MANY_VECTORS + 1 : i % 8);
    reserve_sparse();
    run_svd();
    factor(f.p);
    assert_int_equal(f.p->rank, f.svd_rank);
    check_primary_rows(f.p);
    assert_true(f.p->max_b <= km_max_good_b);
    for (int k = f.p->rank; k < f.columns && f.svd_rank == f.rows; ++k)
      chosen += f.p->column[k] < f.rows;
  }
  assert_true(chosen >= 15);
}

enum { SHARED = 3 };

/* Columns that all rows share, and two for each row alone. */
static bool is_shared_or_own(int column, int r) {
  return column < SHARED || (column - SHARED) / 2 == r;
}

/* Local null vectors of columns that many rows share: the numbers and the least solutions are those by Z, whichever
 * of the two they are found by. */
static void crowded_rows(void **state) {
  (void)state;
  double rhs[MOST], least[MOST], work[MOST], step[MOST];
  for (int i = 0; i < 40; ++i) {
    int pairs = 20 + index_below(15);
    open_where(pairs, SHARED + 2 * pairs, is_shared_or_own);
    factor(f.p);
    int freedom = km_factor_freedom(f.p);
    assert_int_equal(freedom, f.columns - f.rows);
    check_numbers(1e-11);
    for (int r = 0; r < f.rows; ++r)
      rhs[r] = any();
    keep_normal(i);
    for (int count = freedom - 1; count <= freedom; ++count) {
      assert_true(km_sparse_minimum_norm(f.p, stored(f.p), count, rhs, least));
      check_rows(f.p->row, f.p->rank, least, rhs, 1e-9); /* all of them */
      memcpy(step, least, sizeof step);
      assert_true(km_sparse_remove_null_space(f.p, stored(f.p), count, step, work));
      for (int c = 0; c < f.columns; ++c)
        assert_near(step[c], least[c], 1e-9);
      assert_true(count == freedom || least[f.p->column[f.p->rank + count]] == 0.0);
    }
    free_normal(i);
  }
}

static int clean(void **state) {
  (void)state;
  km_arena_free(&f.arena);
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(against_the_dense_engine,
                 "The sparse engine finds the dense one's rank, and LAPACK's mobility numbers",
                 "rounding over the smallest pivot, where |B| stays below 1000"),
      cmocka_unit_test(zeros_that_fill),
      cmocka_unit_test(null_vectors_by_their_entries),
      cmocka_unit_test(steps_without_null_vectors),
      cmocka_unit_test(by_rows_alone),
      cmocka_unit_test(rows_that_hardly_differ),
      cmocka_unit_test(rows_beside_a_forced_column),
      cmocka_unit_test(rows_where_no_pivot_tells),
      cmocka_unit_test(columns_where_no_pivot_tells),
      cmocka_unit_test(history_has_no_influence),
      cmocka_unit_test(crowded_rows),
      cmocka_unit_test(much_fill),
  };
  return cmocka_run_group_tests(tests, NULL, clean);
}
