/* Properties of the partition on random matrices of every small size and some larger ones, with LAPACK's singular
 * value decomposition as the judge of rank and null space. All of it by the dense engines and by the sparse one. */
#include "partition/sparse.h"
#include "support/support.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

enum { MOST = 80, SMALL = 14 };

typedef struct problem {
  km_arena arena;
  km_partition p, q;
  int rows, columns, rank;
  double J[MOST * MOST], D[MOST]; /* D: column weights */
  double Z[MOST * MOST], numbers[MOST], svd_numbers[MOST];
  int svd_rank;
  bool forced[MOST];
} problem;

static problem f;
static bool sparse;
static randomness source = {1};

static double any(void) {
  return uniform(&source, -1.0, 1.0);
}

static int index_below(int count) {
  return below(&source, count);
}

static int least(int a, int b) {
  return a < b ? a : b;
}

/* A random rows × columns matrix of the given rank, some of its entries 0. */
static void fill(int rows, int columns, int rank) {
  static double A[MOST * MOST], B[MOST * MOST];
  f.rows = rows;
  f.columns = columns;
  f.rank = rank;
  for (int i = 0; i < rows * rank; ++i)
    A[i] = any() + 1.5 * (i % rows == i / rows); /* near the identity: well conditioned */
  for (int i = 0; i < rank * columns; ++i)
    B[i] = any() + 1.5 * (i % rank == i / rank);
  for (int c = 0; c < columns; ++c) {
    f.D[c] = 0.3 + fabs(any());
    f.forced[c] = false;
    for (int r = 0; r < rows; ++r) {
      double sum = 0.0;
      for (int k = 0; k < rank; ++k)
        sum += A[k * rows + r] * B[c * rank + k];
      f.J[c * rows + r] = sum;
    }
  }
}

static void perturb(double size) {
  int rank = f.rank;
  static double E[MOST * MOST];
  for (int c = 0; c < f.columns; ++c) { /* J ← J (I + E): the rank stays */
    for (int r = 0; r < f.rows; ++r)
      E[c * f.rows + r] = 0.0;
    for (int k = 0; k < f.columns; ++k) {
      double e = size * any();
      for (int r = 0; r < f.rows; ++r)
        E[c * f.rows + r] += e * f.J[k * f.rows + r];
    }
  }
  for (int i = 0; i < f.rows * f.columns; ++i)
    f.J[i] += E[i];
  f.rank = rank;
}

static void run_svd(void) {
  static double A[MOST * MOST], U[MOST * MOST], VT[MOST * MOST], sigma[MOST];
  int n = f.columns;
  for (int c = 0; c < n; ++c)
    for (int r = 0; r < f.rows; ++r)
      A[c * f.rows + r] = f.J[c * f.rows + r] / f.D[c];
  assert_int_equal(LAPACKE_dgesdd(LAPACK_COL_MAJOR, 'A', f.rows, n, A, f.rows, sigma, U, f.rows, VT, n), 0);
  f.svd_rank = 0;
  while (f.svd_rank < least(f.rows, n) && sigma[f.svd_rank] > 1e-9 * sigma[0])
    ++f.svd_rank;
  for (int j = 0; j < n; ++j) {
    f.svd_numbers[j] = 0.0;
    for (int k = f.svd_rank; k < n; ++k)
      f.svd_numbers[j] += VT[j * n + k] * VT[j * n + k];
  }
}

/* For matrices in which every entry may be something else than 0. */
static void reserve_one(km_partition *p, int rows, int columns) {
  if (!sparse) {
    assert_true(km_partition_reserve(p, rows, columns, &f.arena));
    return;
  }
  int *start = KM_ARENA_NEW(&f.arena, int, (size_t)columns + 1);
  int *row = KM_ARENA_NEW(&f.arena, int, (size_t)(rows * columns));
  for (int i = 0; i < rows * columns; ++i)
    row[i] = i % rows;
  for (int c = 0; c <= columns; ++c)
    start[c] = c * rows;
  assert_true(km_partition_reserve_sparse(p, rows, columns, start, row, &f.arena));
}

static void reserve(void) {
  km_arena_free(&f.arena);
  f.arena = (km_arena){0};
  reserve_one(&f.p, f.rows, f.columns);
  reserve_one(&f.q, f.rows, f.columns);
}

/* The matrix as the partition's engine takes it: whole, or the values of its pattern. */
static const double *stored(const km_partition *p) {
  static double values[MOST * MOST];
  if (!p->sparse)
    return f.J;
  for (int c = 0; c < f.columns; ++c)
    for (int i = p->sparse->start[c]; i < p->sparse->start[c + 1]; ++i)
      values[i] = f.J[c * f.rows + p->sparse->row[i]];
  return values;
}

static void factor(km_partition *p) {
  km_partition_factor(p, stored(p), f.rows, f.columns, f.forced, 1e-9);
}

static void check_permutation(const int *list, int count) {
  bool seen[MOST] = {false};
  for (int i = 0; i < count; ++i) {
    assert_in_range(list[i], 0, count - 1);
    assert_false(seen[list[i]]);
    seen[list[i]] = true;
  }
}

static double largest_entry(void) {
  double largest = 0.0;
  for (int i = 0; i < f.rows * f.columns; ++i)
    largest = fmax(largest, fabs(f.J[i]));
  return largest;
}

/* The pivots, and the sign of their product, by elimination in pivot order without exchanges. */
static int eliminate(const km_partition *p, double *pivots) {
  static double A[MOST * MOST];
  int n = p->rank, sign = 1;
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k)
      A[k * n + i] = f.J[p->column[k] * f.rows + p->row[i]];
  for (int s = 0; s < n; ++s) {
    pivots[s] = A[s * n + s];
    sign = A[s * n + s] < 0.0 ? -sign : sign;
    for (int k = s + 1; k < n; ++k)
      for (int i = s + 1; i < n; ++i)
        A[k * n + i] -= A[s * n + i] / A[s * n + s] * A[k * n + s];
  }
  return sign;
}

/* Each pivot is what is left of its entry when those before it are eliminated. */
static void check_pivots(const km_partition *p) {
  double pivots[MOST], rounding = 1e-11 * largest_entry();
  assert_int_equal(p->sign, eliminate(p, pivots));
  for (int i = 0; i < p->rank; ++i)
    assert_near(1.0 / p->inverse[i], pivots[i], rounding + 1e-9 * fabs(pivots[i]));
}

static void check_directions(const km_partition *p) {
  double x[MOST], scale = largest_entry();
  for (int k = p->rank; k < p->columns; ++k) {
    km_partition_direction(p, p->column[k], x);
    assert_near(x[p->column[k]], 1.0, 0.0);
    for (int r = 0; r < f.rows; ++r) {
      double sum = 0.0, size = 0.0;
      for (int c = 0; c < f.columns; ++c) {
        sum += f.J[c * f.rows + r] * x[c];
        size += fabs(f.J[c * f.rows + r] * x[c]);
      }
      assert_true(fabs(sum) <= 1e-11 * (size + scale));
    }
    for (int i = 0; i < p->rank; ++i)
      assert_true(-x[p->column[i]] == p->B[(k - p->rank) * p->rank + i]);
  }
}

static void check_null(const km_partition *p, double tolerance) {
  int freedom = km_partition_freedom(p), n = f.columns;
  km_partition_null(p, f.D, freedom, f.Z);
  for (int a = 0; a < freedom; ++a)
    for (int b = 0; b <= a; ++b) {
      double dot = 0.0;
      for (int j = 0; j < n; ++j)
        dot += f.Z[a * n + j] * f.Z[b * n + j];
      assert_near(dot, a == b ? 1.0 : 0.0, 1e-13);
    }
  km_mobility_numbers(f.Z, n, freedom, f.numbers);
  for (int j = 0; j < n; ++j)
    assert_near(f.numbers[j], f.svd_numbers[j], tolerance);
}

static void check_solution(const km_partition *p) {
  double rhs[MOST], x[MOST], size = 0.0;
  for (int r = 0; r < f.rows; ++r)
    rhs[r] = any();
  km_partition_solve(p, rhs, x);
  for (int c = 0; c < f.columns; ++c)
    size = fmax(size, fabs(x[c]));
  for (int k = p->rank; k < p->columns; ++k)
    assert_true(x[p->column[k]] == 0.0);
  for (int i = 0; i < p->rank; ++i) {
    double sum = -rhs[p->row[i]];
    for (int c = 0; c < f.columns; ++c)
      sum += f.J[c * f.rows + p->row[i]] * x[c];
    assert_true(fabs(sum) <= 1e-11 * (1.0 + size * largest_entry() * f.columns));
  }
}

static void check_all(const km_partition *p, double tolerance) {
  assert_int_equal(p->rank, f.svd_rank);
  check_permutation(p->row, p->rows);
  check_permutation(p->column, p->columns);
  double largest = 0.0;
  for (int i = 0; i < p->rank * km_partition_freedom(p); ++i)
    largest = fmax(largest, fabs(p->B[i]));
  assert_true(p->largest_b == largest);
  check_pivots(p);
  check_directions(p);
  check_null(p, tolerance);
  check_solution(p);
}

/* First and last pivot are those of complete pivoting, in which no entry grows by more than a factor of 2 a step; the
 * sparse engine's are its largest and its smallest. */
static void check_evidence(const km_partition *p) {
  double first = 0.0, last = 0.0;
  for (int i = 0; i < p->rank; ++i) {
    double size = 1.0 / fabs(p->inverse[i]);
    first = sparse ? fmax(first, size) : i == 0 ? size : first;
    last = sparse && i > 0 ? fmin(last, size) : size;
  }
  assert_near(p->first_pivot, first, 1e-14 * first);
  assert_near(p->last_pivot, last, 1e-14 * first);
  assert_true(p->scale == largest_entry());
  assert_true(p->pivoted_b == p->largest_b);
  assert_true(p->rank == 0 || p->last_pivot <= ldexp(p->first_pivot, p->rank - 1));
  assert_true(p->rank == 0 || p->last_pivot > 1e-9 * p->scale);
  assert_true(p->first_dropped <= 1e-9 * p->scale);
  if (p->rank == least(p->rows, p->columns))
    assert_true(p->first_dropped == 0.0);
  if (p->rank > 0 && !sparse)
    assert_true(fabs(p->first_pivot - p->scale) <= 1e-11 * p->scale); /* nothing is forced here */
}

static void every_size(void **state) {
  (void)state;
  for (int rows = 1; rows <= SMALL; ++rows)
    for (int columns = 1; columns <= SMALL; ++columns)
      for (int rank = 0; rank <= least(rows, columns); ++rank) {
        fill(rows, columns, rank);
        reserve();
        run_svd();
        factor(&f.p);
        assert_int_equal(f.svd_rank, rank);
        check_all(&f.p, 1e-10);
        check_evidence(&f.p);
      }
}

static void large_ones(void **state) {
  (void)state;
  static const int sizes[][3] = {{13, 12, 12}, {12, 64, 12}, {12, 65, 11}, {30, 20, 15}, {36, 42, 30}, {80, 80, 77}};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    fill(sizes[i][0], sizes[i][1], sizes[i][2]);
    reserve();
    run_svd();
    factor(&f.p);
    check_all(&f.p, 1e-9);
    check_evidence(&f.p);
    perturb(1e-4);
    run_svd();
    assert_true(km_partition_refactor(&f.p, f.J));
    check_all(&f.p, 1e-9);
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
    factor(&f.p);
    km_partition_factor(&f.q, f.J, rows, columns, NULL, 1e-9);
    assert_int_equal(f.p.rank, f.q.rank);
    if (f.p.largest_b < 1e3)
      check_all(&f.p, 1e-9);
    static double others[MOST * MOST]; /* what is not forced */
    int n = 0;
    for (int c = 0; c < columns; ++c)
      if (!f.forced[c])
        memcpy(others + rows * n++, f.J + rows * c, (size_t)rows * sizeof(double));
    reserve_one(&f.q, rows, n);
    km_partition_factor(&f.q, others, rows, n, NULL, 1e-9);
    assert_int_equal(f.p.forced_dependent, f.q.rank < f.p.rank);
    int behind = columns;
    while (behind > f.p.rank && f.forced[f.p.column[behind - 1]])
      --behind;
    for (int k = f.p.rank; k < behind; ++k)
      assert_false(f.forced[f.p.column[k]]); /* the forced ones come last */
    f.p.held = true;                         /* then they are no pivots at all */
    factor(&f.p);
    assert_int_equal(f.p.rank, f.q.rank);
    assert_false(f.p.forced_dependent);
    for (int k = 0; k < f.p.rank; ++k)
      assert_false(f.forced[f.p.column[k]]);
  }
}

/* The same pivots on other values give what a fresh search gives; on the same values, the same bits. */
static void kept_pivots(void **state) {
  (void)state;
  int accepted = 0;
  for (int i = 0; i < 3000; ++i) {
    int rows = 1 + index_below(SMALL), columns = 1 + index_below(SMALL);
    fill(rows, columns, 1 + index_below(least(rows, columns)));
    if (i % 3 == 0)
      f.forced[index_below(columns)] = true;
    reserve();
    factor(&f.p);
    factor(&f.q);
    assert_true(km_partition_refactor(&f.p, f.J));
    for (int k = 0; k < f.p.rank * km_partition_freedom(&f.p); ++k)
      assert_true(f.p.B[k] == f.q.B[k]);
    perturb(1e-3);
    run_svd();
    if (!km_partition_refactor(&f.p, f.J))
      continue;
    ++accepted;
    assert_int_equal(f.p.searches, 1);
    factor(&f.q);
    assert_int_equal(f.q.searches, 2);
    assert_int_equal(f.p.rank, f.q.rank);
    if (f.p.largest_b < 1e3)
      check_all(&f.p, 1e-9);
  }
  assert_true(accepted > 2500);
}

/* Pivots that no longer serve are refused: |B| grown past twice its value, a vanishing pivot, a dropped rank. */
static void refused_pivots(void **state) {
  (void)state;
  double J[] = {2.0, 0.0, 0.0, 1.0, 0.5, 0.5};
  f.rows = 2;
  f.columns = 3;
  reserve();
  km_partition_factor(&f.p, J, 2, 3, NULL, 1e-9);
  assert_int_equal(f.p.rank, 2);
  assert_true(km_partition_refactor(&f.p, J));
  J[5] = 1.9;
  assert_true(km_partition_refactor(&f.p, J));
  J[5] = 2.1;
  assert_false(km_partition_refactor(&f.p, J));
  J[3] = 0.0;
  assert_false(km_partition_refactor(&f.p, J));
  J[3] = 0.01, J[5] = 0.005; /* B as before, but the pivot has shrunk */
  assert_false(km_partition_refactor(&f.p, J));
  double square[] = {2.0, 0.0, 0.0, 1.0}; /* no freedom left: no B to look at */
  reserve_one(&f.p, 2, 2);
  km_partition_factor(&f.p, square, 2, 2, NULL, 1e-9);
  square[3] = 0.0;
  assert_false(km_partition_refactor(&f.p, square));
}

static void not_finite(void **state) {
  (void)state;
  static const double bad[] = {(double)NAN, HUGE_VAL, -HUGE_VAL, -(double)NAN};
  for (int i = 0; i < 4000; ++i) {
    int rows = 1 + index_below(SMALL + 4), columns = 1 + index_below(SMALL);
    fill(rows, columns, index_below(least(rows, columns) + 1));
    f.forced[index_below(columns)] = i % 2;
    reserve();
    factor(&f.p);
    int count = i % 5 ? 1 + index_below(4) : rows * columns;
    for (int k = 0; k < count; ++k)
      f.J[i % 5 ? index_below(rows * columns) : k] = bad[i % 4];
    assert_false(km_partition_refactor(&f.p, f.J));
    factor(&f.p);
    assert_in_range(f.p.rank, 0, least(rows, columns));
    check_permutation(f.p.row, rows);
    check_permutation(f.p.column, columns);
    assert_false(km_partition_refactor(&f.p, f.J));
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
    factor(&f.p);
    assert_in_range(f.p.rank, 0, i % 3 == 2 ? 0 : least(rows, columns));
    if (i % 3 == 1)
      assert_int_equal(f.p.rank, least(rows, columns));
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
    factor(&f.p);
    assert_int_equal(f.p.rank, n);
    for (int i = 0; i < n; ++i) {
      assert_int_equal(f.p.row[i], i);
      assert_int_equal(f.p.column[i], i);
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
      factor(&f.p);
      assert_int_equal(f.p.rank, 0);
      assert_true(km_partition_refactor(&f.p, f.J));
      km_partition_null(&f.p, f.D, columns, f.Z);
      km_mobility_numbers(f.Z, columns, columns, f.numbers);
      for (int c = 0; c < columns; ++c)
        assert_near(f.numbers[c], 1.0, 1e-15);
    }
}

/* A band with some entries far off, of a rank that is less than full: as a substructure of many loops. */
static void fill_band(int rows, int columns, int *start, int *row) {
  int entries = 0;
  f.rows = rows;
  f.columns = columns;
  memset(f.J, 0, sizeof f.J);
  for (int c = 0; c < columns; ++c) {
    f.D[c] = 0.3 + fabs(any());
    f.forced[c] = false;
    start[c] = entries;
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

/* The sparse engine on patterns with holes, against LAPACK's and against the dense one. */
static void sparse_patterns(void **state) {
  (void)state;
  static int start[MOST + 1], row[MOST * MOST];
  for (int i = 0; i < 400; ++i) {
    fill_band(20 + index_below(50), 20 + index_below(60), start, row);
    reserve();
    assert_true(km_partition_reserve_sparse(&f.p, f.rows, f.columns, start, row, &f.arena));
    if (i % 2)
      f.forced[index_below(f.columns)] = true;
    run_svd();
    factor(&f.p);
    km_partition_factor(&f.q, f.J, f.rows, f.columns, f.forced, 1e-9);
    assert_int_equal(f.p.rank, f.q.rank);
    assert_int_equal(f.p.forced_dependent, f.q.forced_dependent);
    if (f.p.largest_b < 1e3)
      check_all(&f.p, 1e-9);
    if (!(i % 2)) /* as small as complete pivoting keeps it, or nearly */
      assert_true(f.p.largest_b <= 2.0 * fmax(f.q.largest_b, 1.0));
    assert_true(km_partition_reserve_like(&f.q, &f.p, f.rows, f.columns, &f.arena));
    km_partition_copy_pivots(&f.q, &f.p);
    for (int k = 0; k < f.rows * f.columns; ++k)
      f.J[k] *= 1.0 + 1e-7 * any();
    f.q.smallest_pivot = f.p.smallest_pivot;
    f.q.pivoted_b = f.p.pivoted_b;
    bool kept = km_partition_refactor(&f.p, stored(&f.p));
    assert_int_equal(km_partition_refactor(&f.q, stored(&f.q)), kept);
    for (int k = 0; k < f.p.rank * km_partition_freedom(&f.p); ++k)
      assert_true(f.p.B[k] == f.q.B[k]);
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
      cmocka_unit_test(every_size),    cmocka_unit_test(large_ones),     cmocka_unit_test(forced_columns),
      cmocka_unit_test(kept_pivots),   cmocka_unit_test(refused_pivots), cmocka_unit_test(not_finite),
      cmocka_unit_test(extreme_sizes), cmocka_unit_test(empty),
  };
  const struct CMUnitTest dense[] = {cmocka_unit_test(ties)}, holes[] = {cmocka_unit_test(sparse_patterns)};
  int failed = cmocka_run_group_tests(both, NULL, clean) + cmocka_run_group_tests(dense, NULL, clean) +
               cmocka_run_group_tests(holes, NULL, clean);
  return failed + cmocka_run_group_tests(both, use_sparse, clean);
}
