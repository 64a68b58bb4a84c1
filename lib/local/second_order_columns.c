/* Second-order conditions of a substructure with many freedoms, by columns (docs/theory.md 5.5).
 *
 *   c_i(x) = w_iᵀ γ(x) = 0,   J x = 0,   |D x| = 1
 *   step   : min |D δ|² + |s/μ|²  with  J_p δ = 0,   g_i δ + μ s_i = −c_i/size,   δ ⊥ x in D        by sparse QR
 *   μ      = √(1e-9 + 1e-3 worst),  g_i = ∂c_i/∂x / size */
#include "local/second_order_columns.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/second_order_conditions.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_PASSES = 60 };
static const double converged = 1e-9;       /* |c_i| over the scale of the conditions */
static const double violated = 1e-3;        /* |c_i| of a condition that is violated beyond rounding, over the scale */
static const double rank_tolerance = 1e-14; /* tolerance of SPQR: primary rows are independent, and the others are
                                             * damped */

/* Lists the entries of J by row, without locked columns. */
static bool create_row_lists(km_second_order_columns *c, const bool *locked, km_arena *arena) {
  const km_substructure *sub = c->sub;
  const km_pattern *pattern = &sub->pattern;
  c->row_start = KM_ARENA_NEW(arena, int, (size_t)sub->rows + 2);
  c->column = KM_ARENA_NEW(arena, int, pattern->size);
  c->value_index = KM_ARENA_NEW(arena, int, pattern->size);
  if (arena->failed)
    return false;
  /* The first pass counts, the second one places the entries: row_start[r + 1] is then the next free index of row r. */
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

/* Left null vectors from the sparse factor of Jᵀ: one per secondary row, with entries in few rows. */
static bool find_left_null_vectors(km_second_order_columns *c, double tolerance, km_arena *scratch, km_arena *arena) {
  int rows = c->sub->rows, entries = c->row_start[rows];
  size_t row_capacity = 0, value_capacity = 0;
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
    if (!km_arena_grow(arena, (void **)&c->w_row, &row_capacity, (size_t)(first + count), sizeof *c->w_row) ||
        !km_arena_grow(arena, (void **)&c->w, &value_capacity, (size_t)(first + count), sizeof *c->w))
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

static int compare_ints(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

/* Lists the columns on which each condition depends. */
static bool create_column_lists(km_second_order_columns *c, km_arena *scratch, km_arena *arena) {
  size_t capacity = 0;
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
        if (!km_arena_grow(arena, (void **)&c->g_column, &capacity, (size_t)end + 1, sizeof *c->g_column))
          return false;
        c->g_column[end++] = c->column[n];
      }
    c->g_start[k + 1] = end;
    if (end > c->g_start[k])
      qsort(c->g_column + c->g_start[k], (size_t)(end - c->g_start[k]), sizeof *c->g_column, compare_ints);
  }
  return true;
}

static bool reserve_arrays(km_second_order_columns *c, km_arena *arena) {
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

/* Creates the left null vectors, the sparse lists and the QR of the conditions. */
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
  bool is_ok = create_row_lists(out, s->partition[index].locked, arena) &&
               find_left_null_vectors(out, tolerance, &scratch, arena) && create_column_lists(out, &scratch, arena) &&
               reserve_arrays(out, arena);
  km_arena_free(&scratch);
  if (!is_ok)
    return km_fail(error, KM_MEMORY, "out of memory for the conditions of second order");
  return km_sparse_qr_create(sub->columns + out->conditions, out->rank + out->conditions + 1,
                             out->row_start[sub->rows] + out->g_start[out->conditions] + out->conditions + sub->columns,
                             &out->q, error);
}

void km_second_order_columns_free(km_second_order_columns *c) {
  km_sparse_qr_free(c->q);
  c->q = NULL;
}

/* Values c_i and gradients over the weights at x. Returns the largest length of a gradient. */
static double evaluate_conditions(km_second_order_columns *c, const double *x) {
  const km_substructure *sub = c->sub;
  const double *weight = c->m->column_weight + sub->column_start;
  double max_gradient = 0.0;
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
    max_gradient = fmax(max_gradient, sqrt(square));
  }
  return max_gradient;
}

/* Largest |c_i| over the scale. */
static double max_violation(const km_second_order_columns *c) {
  double worst = 0.0;
  for (int k = 0; k < c->conditions; ++k)
    worst = fmax(worst, fabs(c->value[k]) / c->size);
  return worst;
}

/* Fills the matrix of a step: J_p over the weights; gradients of the conditions, each with a slack unknown of
 * coefficient `damping`; and D x. The minimum-norm solution then minimises |D δ|² + |slack|² and is orthogonal to x,
 * since otherwise many conditions would merely shorten x. */
static void fill_step_matrix(const km_second_order_columns *c, double damping, const double *x) {
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

/* One damped Gauss-Newton step, then normalisation to |D x| = 1. */
static bool take_step(km_second_order_columns *c, double damping, double *x) {
  const double *weight = c->m->column_weight + c->sub->column_start;
  fill_step_matrix(c, damping, x);
  memset(c->b, 0, ((size_t)c->rank + (size_t)c->conditions + 1) * sizeof *c->b);
  for (int k = 0; k < c->conditions; ++k)
    c->b[c->rank + k] = -c->value[k] / c->size;
  if (!km_sparse_qr_factor(c->q, rank_tolerance) || !km_sparse_qr_minimum_norm(c->q, c->b, c->z))
    return false;
  for (int k = 0; k < c->sub->columns; ++k)
    x[k] += c->z[k] / weight[k];
  double length = km_step_length(c->m, c->sub, x);
  for (int k = 0; k < c->sub->columns; ++k)
    x[k] /= length;
  return isfinite(length) && length > 0.0;
}

/* Evaluates the conditions at the first x and sets their scale. False if all conditions can be due to the misfit of the
 * configuration. */
static bool evaluate_start(km_second_order_columns *c, const double *x) {
  double noise = fmax(1e-7, 100.0 * c->residual), max_gradient = evaluate_conditions(c, x);
  c->size = fmax(c->size, 0.5 * max_gradient); /* a quadratic form is half its derivative along x */
  return c->conditions > 0 && c->size >= noise;
}

bool km_second_order_columns_refutes(km_second_order_columns *c, const double *x) {
  return evaluate_start(c, x) && max_violation(c) > violated;
}

/* Damped Gauss-Newton iteration onto the tangent cone. */
bool km_second_order_columns_solve(km_second_order_columns *c, double *x) {
  if (!evaluate_start(c, x))
    return true;
  for (int pass = 0; pass < MAX_PASSES; ++pass) {
    double worst = max_violation(c);
    if (worst < converged)
      return true;
    if (!take_step(c, sqrt(1e-9 + 1e-3 * worst), x))
      return false;
    evaluate_conditions(c, x);
  }
  return max_violation(c) < km_condition_tolerance;
}
