/* The second-order conditions of a substructure with many freedoms, in its columns instead of its freedoms. */
#include "local/second_order_columns.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/second_order_conditions.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_PASSES = 60 };
static const double met = 1e-9;      /* a condition over the size of its kind */
static const double broken = 1e-3;   /* the same, of one that random directions break */
static const double spanned = 1e-14; /* primary rows are independent, and the others are damped */

/* The entries of J by row, those of locked columns left out. */
static bool list_rows(km_second_order_columns *c, const bool *locked, km_arena *arena) {
  const km_substructure *sub = c->sub;
  const km_pattern *pattern = &sub->pattern;
  c->row_start = KM_ARENA_NEW(arena, int, (size_t)sub->rows + 2);
  c->column = KM_ARENA_NEW(arena, int, pattern->size);
  c->value_index = KM_ARENA_NEW(arena, int, pattern->size);
  if (arena->failed)
    return false;
  /* The first pass counts, the second one places: row_start[r + 1] is then the next place of row r. */
  for (int pass = 0; pass < 2; ++pass) {
    for (int k = 0; k < sub->columns; ++k) {
      int first = pattern->start ? pattern->start[k] : k * sub->rows;
      int end = pattern->start ? pattern->start[k + 1] : first + sub->rows;
      for (int i = first; i < end && !(locked && locked[k]); ++i) {
        int row = pattern->start ? pattern->row[i] : i - first;
        if (pass == 0) {
          c->row_start[row + 2]++;
          continue;
        }
        c->column[c->row_start[row + 1]] = k;
        c->value_index[c->row_start[row + 1]++] = i;
      }
    }
    for (int r = 0; r < sub->rows && pass == 0; ++r)
      c->row_start[r + 2] += c->row_start[r + 1];
  }
  return true;
}

/* Left null vectors from the sparse factor of Jᵀ: one for each row that others make superfluous, in few rows each. */
static bool find_left(km_second_order_columns *c, double tolerance, km_arena *scratch, km_arena *arena) {
  int rows = c->sub->rows, entries = c->row_start[rows];
  size_t row_room = 0, value_room = 0;
  km_partition p;
  double *values = KM_ARENA_NEW(scratch, double, (size_t)entries),
         *entry = KM_ARENA_NEW(scratch, double, (size_t)rows + 1);
  int *row = KM_ARENA_NEW(scratch, int, (size_t)rows + 1);
  if (scratch->failed || !km_partition_reserve_sparse(&p, c->sub->columns, rows, c->row_start, c->column, scratch))
    return false;
  for (int i = 0; i < entries; ++i)
    values[i] = c->J[c->value_index[i]];
  p.unrestricted_basis = true;
  km_partition_factor(&p, values, c->sub->columns, rows, NULL, tolerance);
  c->rank = p.rank;
  c->conditions = km_partition_freedom(&p);
  c->primary = KM_ARENA_NEW(arena, int, (size_t)p.rank);
  c->w_start = KM_ARENA_NEW(arena, int, (size_t)c->conditions + 1);
  if (p.failed || arena->failed)
    return false;
  memcpy(c->primary, p.column, (size_t)p.rank * sizeof *c->primary);
  for (int k = 0; k < c->conditions; ++k) {
    int first = c->w_start[k], count = km_partition_null_entries(&p, k, row, entry);
    double square = 0.0;
    if (!km_arena_grow(arena, (void **)&c->w_row, &row_room, (size_t)(first + count), sizeof *c->w_row) ||
        !km_arena_grow(arena, (void **)&c->w, &value_room, (size_t)(first + count), sizeof *c->w))
      return false;
    for (int i = 0; i < count; ++i)
      square += entry[i] * entry[i];
    for (int i = 0; i < count; ++i) {
      c->w_row[first + i] = row[i];
      c->w[first + i] = entry[i] / sqrt(square);
    }
    c->w_start[k + 1] = first + count;
  }
  return true;
}

static int ascending(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

/* The columns that each condition depends on. */
static bool list_columns(km_second_order_columns *c, km_arena *scratch, km_arena *arena) {
  size_t room = 0;
  int *seen = KM_ARENA_NEW(scratch, int, (size_t)c->sub->columns);
  c->g_start = KM_ARENA_NEW(arena, int, (size_t)c->conditions + 1);
  if (scratch->failed || arena->failed)
    return false;
  for (int k = 0; k < c->conditions; ++k) {
    int end = c->g_start[k];
    for (int i = c->w_start[k]; i < c->w_start[k + 1]; ++i)
      for (int n = c->row_start[c->w_row[i]]; n < c->row_start[c->w_row[i] + 1]; ++n) {
        if (seen[c->column[n]] > k)
          continue;
        seen[c->column[n]] = k + 1;
        if (!km_arena_grow(arena, (void **)&c->g_column, &room, (size_t)end + 1, sizeof *c->g_column))
          return false;
        c->g_column[end++] = c->column[n];
      }
    c->g_start[k + 1] = end;
    if (end > c->g_start[k])
      qsort(c->g_column + c->g_start[k], (size_t)(end - c->g_start[k]), sizeof *c->g_column, ascending);
  }
  return true;
}

static bool reserve(km_second_order_columns *c, km_arena *arena) {
  size_t rows = (size_t)c->sub->rows, columns = (size_t)c->sub->columns, count = (size_t)c->conditions;
  c->gamma_derivatives = KM_ARENA_NEW(arena, double, c->sub->pattern.size);
  c->gamma = KM_ARENA_NEW(arena, double, rows);
  c->rate = KM_ARENA_NEW(arena, double, (size_t)c->m->coordinate_count);
  c->value = KM_ARENA_NEW(arena, double, count);
  c->g = KM_ARENA_NEW(arena, double, (size_t)c->g_start[c->conditions]);
  c->sum = KM_ARENA_NEW(arena, double, columns);
  c->b = KM_ARENA_NEW(arena, double, (size_t)c->rank + count + 1);
  c->z = KM_ARENA_NEW(arena, double, columns + count);
  return !arena->failed;
}

km_status km_second_order_columns_create(const km_mechanism *m, km_state *s, int index, double tolerance,
                                         km_arena *arena, km_second_order_columns *out, km_error *error) {
  const km_substructure *sub = &m->substructures[index];
  int worst;
  *out = (km_second_order_columns){.m = m, .s = s, .sub = sub, .residual = km_loops_residual(m, s, sub, &worst)};
  out->J = KM_ARENA_NEW(arena, double, sub->pattern.size);
  if (!out->J)
    return km_fail(error, KM_MEMORY, "out of memory for the conditions of second order");
  memcpy(out->J, km_state_jacobian(s, sub), sub->pattern.size * sizeof *out->J);
  km_arena scratch = {0};
  bool made = list_rows(out, s->partition[index].locked, arena) && find_left(out, tolerance, &scratch, arena) &&
              list_columns(out, &scratch, arena) && reserve(out, arena);
  km_arena_free(&scratch);
  if (!made)
    return km_fail(error, KM_MEMORY, "out of memory for the conditions of second order");
  return km_sparse_qr_create(sub->columns + out->conditions, out->rank + out->conditions + 1,
                             out->row_start[sub->rows] + out->g_start[out->conditions] + out->conditions + sub->columns,
                             &out->q, error);
}

void km_second_order_columns_free(km_second_order_columns *c) {
  km_sparse_qr_free(c->q);
  c->q = NULL;
}

/* The conditions' values and derivatives at x; returns the largest derivative, over the weights. */
static double evaluate(km_second_order_columns *c, const double *x) {
  const km_substructure *sub = c->sub;
  const double *weight = c->m->column_weight + sub->column_start;
  double steepest = 0.0;
  for (int k = 0; k < sub->columns; ++k) {
    int coordinate = c->m->column_coordinate[sub->column_start + k];
    c->rate[coordinate] = c->m->unit[coordinate] * x[k];
  }
  km_loops_velocity_products(c->m, c->s, sub, c->rate, c->gamma);
  km_loops_velocity_slopes(c->m, c->s, sub, c->rate, c->gamma_derivatives);
  for (int k = 0; k < c->conditions; ++k) {
    double value = 0.0, square = 0.0;
    for (int i = c->w_start[k]; i < c->w_start[k + 1]; ++i) {
      int row = c->w_row[i];
      value += c->w[i] * c->gamma[row];
      for (int n = c->row_start[row]; n < c->row_start[row + 1]; ++n)
        c->sum[c->column[n]] += c->w[i] * c->gamma_derivatives[c->value_index[n]];
    }
    c->value[k] = value;
    for (int i = c->g_start[k]; i < c->g_start[k + 1]; ++i) {
      int column = c->g_column[i];
      c->g[i] = c->sum[column] / weight[column];
      c->sum[column] = 0.0;
      square += c->g[i] * c->g[i];
    }
    steepest = fmax(steepest, sqrt(square));
  }
  return steepest;
}

static double worst_value(const km_second_order_columns *c) {
  double worst = 0.0;
  for (int k = 0; k < c->conditions; ++k)
    worst = fmax(worst, fabs(c->value[k]) / c->size);
  return worst;
}

/* J over the weights, then the conditions' derivatives with an unknown of their own each, `damping` times which is what may be
 * left of it: the least step is that of least |D δx|² + |left / damping|². It is at right angles to x: where conditions are many,
 * nothing would meet them all but a shorter x, and that is no other direction. */
static void fill(const km_second_order_columns *c, double damping, const double *x) {
  const double *weight = c->m->column_weight + c->sub->column_start;
  km_columns out = km_sparse_qr_columns(c->q);
  long next = 0;
  for (int k = 0; k < c->rank; ++k) {
    for (int i = c->row_start[c->primary[k]]; i < c->row_start[c->primary[k] + 1]; ++i) {
      out.row[next] = c->column[i];
      out.value[next++] = c->J[c->value_index[i]] / weight[c->column[i]];
    }
    out.start[k + 1] = next;
  }
  for (int k = 0; k < c->conditions; ++k) {
    for (int i = c->g_start[k]; i < c->g_start[k + 1]; ++i) {
      out.row[next] = c->g_column[i];
      out.value[next++] = c->g[i] / c->size;
    }
    out.row[next] = c->sub->columns + k;
    out.value[next++] = damping;
    out.start[c->rank + k + 1] = next;
  }
  for (int k = 0; k < c->sub->columns; ++k) {
    out.row[next] = k;
    out.value[next] = weight[k] * x[k];
    next += out.value[next] != 0.0;
  }
  out.start[c->rank + c->conditions + 1] = next;
}

/* One step, and back to length 1. */
static bool step(km_second_order_columns *c, double damping, double *x) {
  const double *weight = c->m->column_weight + c->sub->column_start;
  fill(c, damping, x);
  memset(c->b, 0, ((size_t)c->rank + (size_t)c->conditions + 1) * sizeof *c->b);
  for (int k = 0; k < c->conditions; ++k)
    c->b[c->rank + k] = -c->value[k] / c->size;
  if (!km_sparse_qr_factor(c->q, spanned) || !km_sparse_qr_minimum_norm(c->q, c->b, c->z))
    return false;
  for (int k = 0; k < c->sub->columns; ++k)
    x[k] += c->z[k] / weight[k];
  double length = km_step_length(c->m, c->sub, x);
  for (int k = 0; k < c->sub->columns; ++k)
    x[k] /= length;
  return isfinite(length) && length > 0.0;
}

/* Evaluates at a first x. False where all conditions may be what the pose's misfit makes of 0. */
static bool begin(km_second_order_columns *c, const double *x) {
  double noise = fmax(1e-7, 100.0 * c->residual), steepest = evaluate(c, x);
  c->size = fmax(c->size, 0.5 * steepest); /* a condition is half its derivative along x */
  return c->conditions > 0 && c->size >= noise;
}

bool km_second_order_columns_refutes(km_second_order_columns *c, const double *x) {
  return begin(c, x) && worst_value(c) > broken;
}

bool km_second_order_columns_solve(km_second_order_columns *c, double *x) {
  if (!begin(c, x))
    return true;
  for (int pass = 0; pass < MOST_PASSES; ++pass) {
    double worst = worst_value(c);
    if (worst < met)
      return true;
    if (!step(c, sqrt(1e-9 + 1e-3 * worst), x))
      return false;
    evaluate(c, x);
  }
  return worst_value(c) < km_condition_tolerance;
}
