/* Second-order conditions by columns: one condition per left null vector, each with few entries (docs/theory.md 5.5).
 *
 *   c_i(a) = w_iᵀ γ(D⁻¹ a) = 0,   J D⁻¹ a = 0,   |a| = 1;   γ is quadratic with derivatives in the pattern of J
 *   step   : min |δ|² + |s|²  with  J_p D⁻¹ δ = 0,   g_i δ + μ s_i = −c_i/scale,   δ ⊥ a        by sparse QR
 *   g_i    = ∂c_i/∂a / scale,  μ² the damping */
#include "local/second_order_columns.h"
#include "base/number/tolerances.h"

#include "kinematics/loop_equations.h"
#include "linalg/sparse/sparse_qr.h"

#include <stdlib.h>
#include <string.h>

/* Left null vectors of unit length by their entries, and the dependence of the conditions on the columns. */
struct km_second_order_columns {
  int rank, *primary;      /* [rank] primary rows of J */
  int *row_start, *column; /* [rows + 2] entries of J by row: their columns, ascending, */
  int *value_index;        /* and the indices of their values in J */
  int conditions;
  int *w_start, *w_row;      /* rows of each w_i, */
  double *w;                 /* and its entries */
  int *g_start, *g_column;   /* columns on which each condition depends, ascending */
  double *J;                 /* [pattern.size] Jacobian of the configuration */
  double *gamma_derivatives; /* [pattern.size] ∂γ/∂x */
  double *gamma;             /* [rows] */
  double *rate;              /* [coordinate] */
  double *value, *g;         /* values of the conditions; their derivatives, by g_start */
  double *sum;               /* [columns] accumulator, 0 between conditions */
  double *b, *z;             /* right side and solution of a step */
  km_sparse_qr *q;
};

/* Lists the entries of J by row, without locked columns. */
static bool create_row_lists(km_second_order_columns *c, const km_local *l) {
  const km_substructure *sub = l->sub;
  const bool *locked = km_state_locked_columns(l->s, l->index);
  const km_pattern *pattern = &sub->pattern;
  c->row_start = KM_ARENA_NEW(l->arena, int, (size_t)sub->rows + 2);
  c->column = KM_ARENA_NEW(l->arena, int, pattern->size);
  c->value_index = KM_ARENA_NEW(l->arena, int, pattern->size);
  if (l->arena->failed)
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
static bool find_left_null_vectors(km_second_order_columns *c, const km_local *l, km_arena *scratch) {
  int rows = l->sub->rows, entries = c->row_start[rows];
  size_t row_capacity = 0, value_capacity = 0;
  double *values = KM_ARENA_NEW(scratch, double, (size_t)entries),
         *entry = KM_ARENA_NEW(scratch, double, (size_t)rows + 1);
  int *row = KM_ARENA_NEW(scratch, int, (size_t)rows + 1);
  km_factor *p = km_factor_create_sparse(l->sub->columns, rows, c->row_start, c->column, NULL, scratch);
  if (!p)
    return false;
  for (int i = 0; i < entries; ++i)
    values[i] = c->J[c->value_index[i]];
  km_factor_compute(p, values, l->sub->columns, rows,
                    &(km_factor_options){.tolerance = l->tolerance, .basis = KM_BASIS_ENTRIES});
  c->rank = km_factor_rank(p);
  c->conditions = km_factor_freedom(p);
  c->primary = KM_ARENA_NEW(l->arena, int, (size_t)c->rank);
  c->w_start = KM_ARENA_NEW(l->arena, int, (size_t)c->conditions + 1);
  if (km_factor_has_failed(p) || l->arena->failed)
    return false;
  memcpy(c->primary, km_factor_column_order(p), (size_t)c->rank * sizeof *c->primary);
  for (int k = 0; k < c->conditions; ++k) {
    int first = c->w_start[k], count = km_factor_null_entries(p, k, row, entry);
    double square = 0.0;
    if (!km_arena_grow(l->arena, (void **)&c->w_row, &row_capacity, (size_t)(first + count), sizeof *c->w_row) ||
        !km_arena_grow(l->arena, (void **)&c->w, &value_capacity, (size_t)(first + count), sizeof *c->w))
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
static bool create_column_lists(km_second_order_columns *c, const km_local *l, km_arena *scratch) {
  size_t capacity = 0;
  int *seen = KM_ARENA_NEW(scratch, int, (size_t)l->sub->columns);
  c->g_start = KM_ARENA_NEW(l->arena, int, (size_t)c->conditions + 1);
  if (scratch->failed || l->arena->failed)
    return false;
  for (int k = 0; k < c->conditions; ++k) {
    int end = c->g_start[k];
    for (int i = c->w_start[k]; i < c->w_start[k + 1]; ++i)
      for (int n = c->row_start[c->w_row[i]]; n < c->row_start[c->w_row[i] + 1]; ++n) {
        if (seen[c->column[n]] > k)
          continue;
        seen[c->column[n]] = k + 1;
        if (!km_arena_grow(l->arena, (void **)&c->g_column, &capacity, (size_t)end + 1, sizeof *c->g_column))
          return false;
        c->g_column[end++] = c->column[n];
      }
    c->g_start[k + 1] = end;
    if (end > c->g_start[k])
      qsort(c->g_column + c->g_start[k], (size_t)(end - c->g_start[k]), sizeof *c->g_column, compare_ints);
  }
  return true;
}

static bool reserve_arrays(km_second_order_columns *c, const km_local *l) {
  size_t rows = (size_t)l->sub->rows, columns = (size_t)l->sub->columns, count = (size_t)c->conditions;
  c->gamma_derivatives = KM_ARENA_NEW(l->arena, double, l->sub->pattern.size);
  c->gamma = KM_ARENA_NEW(l->arena, double, rows);
  c->rate = KM_ARENA_NEW(l->arena, double, (size_t)l->m->coordinate_count);
  c->value = KM_ARENA_NEW(l->arena, double, count);
  c->g = KM_ARENA_NEW(l->arena, double, (size_t)c->g_start[c->conditions]);
  c->sum = KM_ARENA_NEW(l->arena, double, columns);
  c->b = KM_ARENA_NEW(l->arena, double, (size_t)c->rank + count + 1);
  c->z = KM_ARENA_NEW(l->arena, double, columns + count);
  return !l->arena->failed;
}

/* Creates the left null vectors, the sparse lists and the QR of the conditions. */
km_status km_second_order_columns_create(km_local *l, km_error *error) {
  const km_substructure *sub = l->sub;
  km_second_order_columns *c = l->columns = KM_ARENA_NEW(l->arena, km_second_order_columns, 1);
  km_arena scratch = {0};
  bool is_ok = c && (c->J = KM_ARENA_NEW(l->arena, double, sub->pattern.size));
  if (is_ok)
    memcpy(c->J, km_state_jacobian(l->s, sub), sub->pattern.size * sizeof *c->J);
  is_ok = is_ok && create_row_lists(c, l) && find_left_null_vectors(c, l, &scratch) &&
          create_column_lists(c, l, &scratch) && reserve_arrays(c, l);
  km_arena_free(&scratch);
  if (!is_ok)
    return km_fail(error, KM_MEMORY, "out of memory for the conditions of second order");
  l->conditions = c->conditions;
  return km_sparse_qr_create(sub->columns + c->conditions, c->rank + c->conditions + 1,
                             c->row_start[sub->rows] + c->g_start[c->conditions] + c->conditions + sub->columns, &c->q,
                             error);
}

void km_second_order_columns_free(km_second_order_columns *c) {
  if (c)
    km_sparse_qr_free(c->q);
}

/* Values c_i and their derivatives. */
double km_second_order_columns_evaluate(km_local *l, const double *a, double *steepest) {
  km_second_order_columns *c = l->columns;
  const km_substructure *sub = l->sub;
  double worst = 0.0;
  for (int k = 0; k < sub->columns; ++k) {
    int coordinate = l->m->column_coordinate[sub->column_start + k];
    c->rate[coordinate] = l->m->unit[coordinate] * a[k] / l->weight[k];
  }
  km_loops_velocity_products(l->m, l->s, sub, c->rate, c->gamma);
  km_loops_velocity_slopes(l->m, l->s, sub, c->rate, c->gamma_derivatives);
  *steepest = 0.0;
  for (int k = 0; k < c->conditions; ++k) {
    double value = 0.0, square = 0.0;
    for (int i = c->w_start[k]; i < c->w_start[k + 1]; ++i) {
      int row = c->w_row[i];
      value += c->w[i] * c->gamma[row];
      for (int n = c->row_start[row]; n < c->row_start[row + 1]; ++n)
        c->sum[c->column[n]] += c->w[i] * c->gamma_derivatives[c->value_index[n]];
    }
    c->value[k] = value;
    worst = fmax(worst, fabs(value));
    for (int i = c->g_start[k]; i < c->g_start[k + 1]; ++i) {
      int column = c->g_column[i];
      c->g[i] = c->sum[column] / l->weight[column];
      c->sum[column] = 0.0;
      square += c->g[i] * c->g[i];
    }
    *steepest = fmax(*steepest, sqrt(square));
  }
  return worst;
}

/* Fills the matrix of a step: J_p D⁻¹; derivatives of the conditions, each with a slack unknown of coefficient
 * √damping; and a. The minimum-norm solution then minimises |δ|² + |slack|² and is orthogonal to a: otherwise many
 * conditions would merely shorten a. */
static void fill_step_matrix(const km_local *l, double damping, const double *a) {
  const km_second_order_columns *c = l->columns;
  km_columns out = km_sparse_qr_columns(c->q);
  long next = 0;
  for (int k = 0; k < c->rank; ++k) {
    for (int i = c->row_start[c->primary[k]]; i < c->row_start[c->primary[k] + 1]; ++i) {
      out.row[next] = c->column[i];
      out.value[next++] = c->J[c->value_index[i]] / l->weight[c->column[i]];
    }
    out.start[k + 1] = next;
  }
  for (int k = 0; k < c->conditions; ++k) {
    for (int i = c->g_start[k]; i < c->g_start[k + 1]; ++i) {
      out.row[next] = c->g_column[i];
      out.value[next++] = c->g[i] / l->scale;
    }
    out.row[next] = l->sub->columns + k;
    out.value[next++] = sqrt(damping);
    out.start[c->rank + k + 1] = next;
  }
  for (int k = 0; k < l->sub->columns; ++k) {
    out.row[next] = k;
    out.value[next] = a[k];
    next += a[k] != 0.0;
  }
  out.start[c->rank + c->conditions + 1] = next;
}

bool km_second_order_columns_step(km_local *l, double damping, double *a) {
  km_second_order_columns *c = l->columns;
  fill_step_matrix(l, damping, a);
  memset(c->b, 0, ((size_t)c->rank + (size_t)c->conditions + 1) * sizeof *c->b);
  for (int k = 0; k < c->conditions; ++k)
    c->b[c->rank + k] = -c->value[k] / l->scale;
  if (!km_sparse_qr_factor(c->q, km_sum_rounding) || !km_sparse_qr_minimum_norm(c->q, c->b, c->z))
    return false;
  for (int k = 0; k < l->sub->columns; ++k)
    a[k] += c->z[k];
  return true;
}
