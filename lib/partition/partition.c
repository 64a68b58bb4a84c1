#include "partition/partition.h"

#include <math.h>
#include <string.h>

bool km_partition_reserve(km_partition *p, int rows, int columns, km_arena *arena) {
  size_t r = (size_t)rows, c = (size_t)columns;
  *p = (km_partition){.row = KM_ARENA_NEW(arena, int, r),
                      .column = KM_ARENA_NEW(arena, int, c),
                      .lu = KM_ARENA_NEW(arena, double, r *c),
                      .B = KM_ARENA_NEW(arena, double, r *c)};
  return !arena->failed;
}

typedef struct pivot {
  int row, column;
  double size;
} pivot;

/* Largest entry of the trailing matrix in columns from … to-1 (positions after permutation). */
static pivot search(const km_partition *p, int step, int from, int to) {
  pivot best = {step, from, -1.0};
  for (int c = from; c < to; ++c) {
    const double *column = p->lu + (size_t)c * (size_t)p->rows;
    for (int r = step; r < p->rows; ++r) {
      double size = fabs(column[r]);
      if (size > best.size)
        best = (pivot){r, c, size};
    }
  }
  return best;
}

static void swap_ints(int *a, int i, int j) {
  int t = a[i];
  a[i] = a[j];
  a[j] = t;
}

static void swap_rows(km_partition *p, int i, int j) {
  if (i == j)
    return;
  for (int c = 0; c < p->columns; ++c) {
    double *column = p->lu + (size_t)c * (size_t)p->rows, t = column[i];
    column[i] = column[j];
    column[j] = t;
  }
  swap_ints(p->row, i, j);
}

static void swap_columns(km_partition *p, int i, int j) {
  if (i == j)
    return;
  double *a = p->lu + (size_t)i * (size_t)p->rows, *b = p->lu + (size_t)j * (size_t)p->rows;
  for (int r = 0; r < p->rows; ++r) {
    double t = a[r];
    a[r] = b[r];
    b[r] = t;
  }
  swap_ints(p->column, i, j);
}

/* One step of elimination on `rows` rows. */
static void eliminate(double *lu, int ld, int rows, int columns, int step) {
  double *l = lu + (size_t)step * (size_t)ld, inverse = 1.0 / l[step];
  for (int r = step + 1; r < rows; ++r)
    l[r] *= inverse;
  for (int c = step + 1; c < columns; ++c) {
    double *column = lu + (size_t)c * (size_t)ld, u = column[step];
    for (int r = step + 1; r < rows; ++r)
      column[r] -= l[r] * u;
  }
}

/* B = U⁻¹U_R; sets largest_b and sign. */
static void back_substitute(km_partition *p) {
  int rank = p->rank;
  size_t ld = (size_t)p->rows;
  p->largest_b = 0.0;
  p->sign = 1;
  for (int i = 0; i < rank; ++i)
    if (p->lu[(size_t)i * ld + (size_t)i] < 0.0)
      p->sign = -p->sign;
  for (int k = rank; k < p->columns; ++k) {
    double *b = p->B + (size_t)(k - rank) * (size_t)rank;
    memcpy(b, p->lu + (size_t)k * ld, (size_t)rank * sizeof *b);
    for (int i = rank - 1; i >= 0; --i) {
      const double *u = p->lu + (size_t)i * ld;
      b[i] /= u[i];
      for (int r = 0; r < i; ++r)
        b[r] -= u[r] * b[i];
      p->largest_b = fmax(p->largest_b, fabs(b[i]));
    }
  }
}

/* Moves the forced columns behind the others; returns how many columns are free to be chosen. */
static int order_columns(km_partition *p, const bool *forced) {
  int free = 0, behind = p->columns;
  for (int c = 0; c < p->columns; ++c) {
    if (forced && forced[c])
      p->column[--behind] = c;
    else
      p->column[free++] = c;
  }
  return free;
}

static void load(km_partition *p, const double *matrix) {
  p->scale = 0.0;
  for (int c = 0; c < p->columns; ++c) {
    const double *from = matrix + (size_t)p->column[c] * (size_t)p->rows;
    double *to = p->lu + (size_t)c * (size_t)p->rows;
    for (int r = 0; r < p->rows; ++r) {
      to[r] = from[r];
      p->scale = fmax(p->scale, fabs(from[r]));
    }
  }
}

void km_partition_factor(km_partition *p, const double *matrix, int rows, int columns, const bool *forced,
                         double tolerance) {
  p->rows = rows;
  p->columns = columns;
  for (int r = 0; r < rows; ++r)
    p->row[r] = r;
  int free = order_columns(p, forced);
  load(p, matrix);
  p->first_pivot = p->last_pivot = p->first_dropped = 0.0;
  p->forced_dependent = false;
  double threshold = tolerance * p->scale;
  int step = 0;
  for (; step < rows && step < columns; ++step) {
    int from = step, to = step < free ? free : columns;
    pivot best = search(p, step, from, to);
    if (!(best.size > threshold) && to < columns) {
      best = search(p, step, to, columns);
      free = 0; /* the free columns are used up */
    }
    if (!(best.size > threshold)) {
      p->first_dropped = fmax(best.size, 0.0);
      break;
    }
    p->forced_dependent = p->forced_dependent || (forced && forced[p->column[best.column]]);
    swap_columns(p, step, best.column);
    swap_rows(p, step, best.row);
    eliminate(p->lu, rows, rows, columns, step);
    if (step == 0)
      p->first_pivot = best.size;
    p->last_pivot = best.size;
  }
  p->rank = step;
  p->searches++;
  back_substitute(p);
  p->pivoted_b = p->largest_b;
}

bool km_partition_refactor(km_partition *p, const double *matrix) {
  int rank = p->rank;
  size_t ld = (size_t)p->rows;
  for (int c = 0; c < p->columns; ++c) {
    const double *from = matrix + (size_t)p->column[c] * ld;
    double *to = p->lu + (size_t)c * ld;
    for (int r = 0; r < rank; ++r)
      to[r] = from[p->row[r]];
  }
  for (int step = 0; step < rank; ++step)
    eliminate(p->lu, p->rows, rank, p->columns, step);
  back_substitute(p);
  /* A rank that drops shrinks a pivot together with what stands right of it: B alone needn't show it. */
  double smallest = INFINITY, sum = 0.0;
  for (int i = 0; i < rank; ++i)
    smallest = fmin(smallest, fabs(p->lu[(size_t)i * ld + (size_t)i]));
  for (int i = 0; i < rank * (p->columns - rank); ++i)
    sum += p->B[i];
  return isfinite(sum) && p->largest_b <= 2.0 * fmax(p->pivoted_b, 1.0) && (rank == 0 || smallest >= 0.1 * p->last_pivot);
}

void km_partition_solve(const km_partition *p, const double *rhs, double *x) {
  int rank = p->rank;
  size_t ld = (size_t)p->rows;
  for (int c = rank; c < p->columns; ++c)
    x[p->column[c]] = 0.0;
  for (int i = 0; i < rank; ++i) {
    double sum = rhs[p->row[i]];
    for (int k = 0; k < i; ++k)
      sum -= p->lu[(size_t)k * ld + (size_t)i] * x[p->column[k]];
    x[p->column[i]] = sum;
  }
  for (int i = rank - 1; i >= 0; --i) {
    double sum = x[p->column[i]];
    for (int k = i + 1; k < rank; ++k)
      sum -= p->lu[(size_t)k * ld + (size_t)i] * x[p->column[k]];
    x[p->column[i]] = sum / p->lu[(size_t)i * ld + (size_t)i];
  }
}

/* Modified Gram-Schmidt, twice: with a forced driver near its toggle N is badly conditioned, and one pass
 * would leave its columns that much out of square. */
static void orthonormalise(double *Z, int columns, int freedom) {
  size_t n = (size_t)columns;
  for (int k = 0; k < freedom; ++k) {
    double *z = Z + (size_t)k * n;
    for (int pass = 0; pass < (k ? 2 : 1); ++pass) {
      for (int o = 0; o < k; ++o) {
        const double *y = Z + (size_t)o * n;
        double dot = 0.0;
        for (size_t i = 0; i < n; ++i)
          dot += y[i] * z[i];
        for (size_t i = 0; i < n; ++i)
          z[i] -= dot * y[i];
      }
    }
    double sum = 0.0;
    for (size_t i = 0; i < n; ++i)
      sum += z[i] * z[i];
    double inverse = 1.0 / sqrt(sum);
    for (size_t i = 0; i < n; ++i)
      z[i] *= inverse;
  }
}

void km_partition_null(const km_partition *p, const double *weight, int count, double *Z) {
  int rank = p->rank;
  size_t n = (size_t)p->columns;
  for (int k = 0; k < count; ++k) {
    double *z = Z + (size_t)k * n;
    const double *b = p->B + (size_t)k * (size_t)rank;
    for (int c = rank; c < p->columns; ++c)
      z[p->column[c]] = 0.0;
    for (int i = 0; i < rank; ++i)
      z[p->column[i]] = -b[i] * weight[p->column[i]];
    z[p->column[rank + k]] = weight[p->column[rank + k]];
  }
  orthonormalise(Z, p->columns, count);
}

void km_partition_direction(const km_partition *p, int column, double *direction) {
  int rank = p->rank, k = rank;
  while (p->column[k] != column)
    ++k;
  const double *b = p->B + (size_t)(k - rank) * (size_t)rank;
  for (int c = rank; c < p->columns; ++c)
    direction[p->column[c]] = 0.0;
  for (int i = 0; i < rank; ++i)
    direction[p->column[i]] = -b[i];
  direction[column] = 1.0;
}

void km_mobility_numbers(const double *Z, int columns, int freedom, double *numbers) {
  for (int j = 0; j < columns; ++j)
    numbers[j] = 0.0;
  for (int k = 0; k < freedom; ++k)
    for (int j = 0; j < columns; ++j)
      numbers[j] += Z[(size_t)k * (size_t)columns + (size_t)j] * Z[(size_t)k * (size_t)columns + (size_t)j];
}
