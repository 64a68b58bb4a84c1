/* Random matrices, their singular values, and the laws of a partition. */
#include "support/matrices.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

problem f;
bool sparse;
static randomness source = {1};

double any(void) {
  return uniform(&source, -1.0, 1.0);
}

int index_below(int count) {
  return below(&source, count);
}

int least(int a, int b) {
  return a < b ? a : b;
}

void fill(int rows, int columns, int rank) {
  static double A[MOST * MOST], B[MOST * MOST];
  f.rows = rows;
  f.columns = columns;
  f.rank = rank;
  for (int i = 0; i < rows * rank; ++i)
    A[i] = any() + 1.5 * (i % rows == i / rows); /* well conditioned, near the identity */
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

void perturb(double size) {
  int rank = f.rank;
  static double E[MOST * MOST];
  for (int c = 0; c < f.columns; ++c) {
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

void run_svd(void) {
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

void reserve_one(km_factor **p, int rows, int columns) {
  if (!sparse) {
    *p = km_factor_create(rows, columns, f.D, &f.arena);
    return;
  }
  int *start = KM_ARENA_NEW(&f.arena, int, (size_t)columns + 1);
  int *row = KM_ARENA_NEW(&f.arena, int, (size_t)(rows * columns));
  for (int i = 0; i < rows * columns; ++i)
    row[i] = i % rows;
  for (int c = 0; c <= columns; ++c)
    start[c] = c * rows;
  *p = km_factor_create_sparse(rows, columns, start, row, f.D, &f.arena);
}

void reserve(void) {
  km_arena_free(&f.arena);
  f.arena = (km_arena){0};
  f.options = (km_factor_options){.tolerance = 1e-9, .forced = f.forced};
  reserve_one(&f.p, f.rows, f.columns);
  reserve_one(&f.q, f.rows, f.columns);
}

const double *stored(const km_factor *p) {
  static double values[MOST * MOST];
  if (!p->sparse)
    return f.J;
  for (int c = 0; c < f.columns; ++c)
    for (int i = p->sparse->start[c]; i < p->sparse->start[c + 1]; ++i)
      values[i] = f.J[c * f.rows + p->sparse->row[i]];
  return values;
}

void factor(km_factor *p) {
  km_factor_compute(p, stored(p), f.rows, f.columns, &f.options);
}

void check_permutation(const int *list, int count) {
  bool seen[MOST] = {false};
  for (int i = 0; i < count; ++i) {
    assert_in_range(list[i], 0, count - 1);
    assert_false(seen[list[i]]);
    seen[list[i]] = true;
  }
}

double largest_entry(void) {
  double largest = 0.0;
  for (int i = 0; i < f.rows * f.columns; ++i)
    largest = fmax(largest, fabs(f.J[i]));
  return largest;
}

/* The pivots, and the sign of their product, by elimination in pivot order without exchanges. */
static int eliminate(km_factor *p, double *pivots) {
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
void check_pivots(km_factor *p) {
  double pivots[MOST], rounding = 1e-11 * largest_entry();
  assert_int_equal(p->sign, eliminate(p, pivots));
  for (int i = 0; i < p->rank; ++i)
    assert_near(1.0 / p->inverse[i], pivots[i], rounding + 1e-9 * fabs(pivots[i]));
}

void check_directions(km_factor *p) {
  double x[MOST], scale = largest_entry();
  for (int k = p->rank; k < p->columns; ++k) {
    km_factor_null_vector(p, p->column[k], x);
    assert_near(x[p->column[k]], 1.0, 0.0);
    for (int r = 0; r < f.rows; ++r) {
      double sum = 0.0, size = 0.0;
      for (int c = 0; c < f.columns; ++c) {
        sum += f.J[c * f.rows + r] * x[c];
        size += fabs(f.J[c * f.rows + r] * x[c]);
      }
      assert_true(fabs(sum) <= 1e-11 * (size + scale));
    }
    const double *b = km_factor_b(p, k - p->rank);
    for (int i = 0; i < p->rank; ++i)
      assert_true(-x[p->column[i]] == b[i]);
  }
}

void check_null(km_factor *p, double tolerance) {
  int freedom = km_factor_freedom(p), n = f.columns;
  memcpy(f.Z, km_factor_null_space(p, freedom), (size_t)(freedom * n) * sizeof *f.Z);
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

void check_solution(km_factor *p) {
  double rhs[MOST], x[MOST], size = 0.0;
  for (int r = 0; r < f.rows; ++r)
    rhs[r] = any();
  km_factor_solve(p, rhs, x);
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

/* R is orthonormal, leaves out the independent columns past `count`, and is at right angles to D times the null vectors
 * of the others. */
static void check_rows(km_factor *p, int count) {
  double x[MOST];
  int n = f.columns;
  const double *R = km_factor_row_space(p, count);
  for (int a = 0; a < p->rank; ++a) {
    for (int b = 0; b <= a; ++b) {
      double dot = 0.0;
      for (int j = 0; j < n; ++j)
        dot += R[a * n + j] * R[b * n + j];
      assert_near(dot, a == b, 1e-13);
    }
    for (int k = p->rank + count; k < n; ++k)
      assert_near(R[a * n + p->column[k]], 0.0, 0.0);
  }
  for (int k = p->rank; k < p->rank + count; ++k) {
    double size = 0.0;
    km_factor_null_vector(p, p->column[k], x);
    for (int j = 0; j < n; ++j)
      size = fmax(size, fabs(f.D[j] * x[j]));
    for (int a = 0; a < p->rank; ++a) {
      double dot = 0.0;
      for (int j = 0; j < n; ++j)
        dot += R[a * n + j] * f.D[j] * x[j];
      assert_near(dot, 0.0, 1e-11 * size * n);
    }
  }
}

void check_all(km_factor *p, double tolerance) {
  assert_near(p->rank, f.svd_rank, 0.0);
  check_permutation(p->row, p->rows);
  check_permutation(p->column, p->columns);
  double largest = 0.0;
  for (int k = 0; k < km_factor_freedom(p); ++k) {
    const double *b = km_factor_b(p, k);
    for (int i = 0; i < p->rank; ++i)
      largest = fmax(largest, fabs(b[i]));
  }
  assert_true((p->sparse ? km_sparse_current_max_b(p) : p->max_b) == largest);
  check_pivots(p);
  check_directions(p);
  check_null(p, tolerance);
  check_rows(p, km_factor_freedom(p));
  check_rows(p, km_factor_freedom(p) / 2);
  check_solution(p);
}

void check_evidence(km_factor *p) {
  double first = 0.0, last = 0.0;
  for (int i = 0; i < p->rank; ++i) {
    double size = 1.0 / fabs(p->inverse[i]);
    first = sparse ? fmax(first, size) : i == 0 ? size : first;
    last = sparse && i > 0 ? fmin(last, size) : size;
  }
  assert_near(p->first_pivot, first, 1e-14 * first);
  assert_near(p->last_pivot, last, 1e-14 * first);
  assert_true(p->scale == largest_entry());
  assert_true(p->max_b_at_search == p->max_b);
  assert_true(p->rank == 0 || p->last_pivot <= ldexp(p->first_pivot, p->rank - 1));
  assert_true(p->rank == 0 || p->last_pivot > 1e-9 * p->scale);
  assert_true(p->first_dropped <= 1e-9 * p->scale);
  if (p->rank == least(p->rows, p->columns))
    assert_true(p->first_dropped == 0.0);
  if (p->rank > 0 && !sparse)
    assert_true(fabs(p->first_pivot - p->scale) <= 1e-11 * p->scale); /* nothing is forced here */
}
