/* Closed configuration nearest to a given one by Newton's method with the Hessian of the closure (docs/theory.md 4.8).
 *
 *   K = [D² − Σ λ_r ∂²e_r   −Jᵀ; J   0],   K (δ, λ) = (−D² (x − y), −e),   x <- x + δ
 *
 * Unknowns of fixed coordinates and secondary rows are removed by unit rows. K is factored by sparse LU (3.6). */
#include "kinematics/nearest_configuration.h"
#include "base/number/tolerances.h"
#include "base/number/vectors.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_ITERATIONS = 12 };

/* Positions of matrix entries, column · size + row, in the order in which they were appended. */
typedef struct entry_list {
  int64_t *keys;
  int count, size;
} entry_list;

static int append_entry(entry_list *l, int row, int column) {
  l->keys[l->count] = (int64_t)column * l->size + row;
  return l->count++;
}

static int compare_keys(const void *a, const void *b) {
  int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
  return (x > y) - (x < y);
}

/* Appends all entries of K: pairs of the Hessian, J and −Jᵀ, the diagonal. Some positions occur several times. */
static void list_entries(const km_substructure *sub, const int *pairs, int pair_count, entry_list *l) {
  const km_pattern *pattern = &sub->pattern;
  for (int i = 0; i < pair_count; ++i) {
    append_entry(l, pairs[2 * i], pairs[2 * i + 1]);
    append_entry(l, pairs[2 * i + 1], pairs[2 * i]);
  }
  for (int c = 0; c < sub->columns; ++c) {
    int first = pattern->start ? pattern->start[c] : c * sub->rows;
    int end = pattern->start ? pattern->start[c + 1] : first + sub->rows;
    for (int i = first; i < end; ++i) {
      int row = sub->columns + (pattern->start ? pattern->row[i] : i - first);
      append_entry(l, row, c);
      append_entry(l, c, row);
    }
  }
  for (int i = 0; i < l->size; ++i)
    append_entry(l, i, i);
}

/* Index of a position in the sorted list of distinct positions. */
static int find_entry(int64_t key, const int64_t *keys, int count) {
  const int64_t *at = bsearch(&key, keys, (size_t)count, sizeof key, compare_keys);
  return (int)(at - keys);
}

/* Merges equal positions into the pattern of K, and stores the index of each appended entry. */
static void merge_entries(km_nearest_configuration *c, const km_substructure *sub, const entry_list *l,
                          int64_t *sorted) {
  int count = 0, next = 0, entries = (int)sub->pattern.size;
  memcpy(sorted, l->keys, (size_t)l->count * sizeof *sorted);
  qsort(sorted, (size_t)l->count, sizeof *sorted, compare_keys);
  for (int i = 0; i < l->count; ++i)
    if (i == 0 || sorted[i] != sorted[count - 1])
      sorted[count++] = sorted[i];
  for (int i = 0; i < count; ++i) {
    c->row[i] = (int)(sorted[i] % l->size);
    c->start[sorted[i] / l->size + 1] = i + 1;
  }
  for (int i = 0; i < 2 * c->hessian_count; ++i)
    c->hessian_index[i] = find_entry(l->keys[next++], sorted, count);
  for (int i = 0; i < entries; ++i) {
    c->J_index[i] = find_entry(l->keys[next++], sorted, count);
    c->transposed_index[i] = find_entry(l->keys[next++], sorted, count);
  }
  for (int i = 0; i < c->size; ++i)
    c->diagonal_index[i] = find_entry(l->keys[next++], sorted, count);
}

/* Creates the pattern of K and the indices of its entries. */
static bool create_pattern(km_nearest_configuration *c, const km_mechanism *m, const km_substructure *sub,
                           km_arena *arena) {
  size_t max_entries = 2 * (size_t)c->hessian_count + 2 * sub->pattern.size + (size_t)c->size;
  km_arena scratch = {0};
  int *pairs = KM_ARENA_NEW(&scratch, int, 2 * (size_t)c->hessian_count + 1);
  int64_t *sorted = KM_ARENA_NEW(&scratch, int64_t, max_entries);
  entry_list l = {.keys = KM_ARENA_NEW(&scratch, int64_t, max_entries), .size = c->size};
  c->start = KM_ARENA_NEW(arena, int, (size_t)c->size + 1);
  c->row = KM_ARENA_NEW(arena, int, max_entries);
  c->value = KM_ARENA_NEW(arena, double, max_entries);
  c->hessian_index = KM_ARENA_NEW(arena, int, 2 * (size_t)c->hessian_count + 1);
  c->J_index = KM_ARENA_NEW(arena, int, sub->pattern.size);
  c->transposed_index = KM_ARENA_NEW(arena, int, sub->pattern.size);
  c->diagonal_index = KM_ARENA_NEW(arena, int, (size_t)c->size);
  bool is_ok = !scratch.failed && !arena->failed;
  if (is_ok) {
    km_loops_hessian_entries(m, sub, pairs);
    list_entries(sub, pairs, c->hessian_count, &l);
    merge_entries(c, sub, &l, sorted);
  }
  km_arena_free(&scratch);
  return is_ok;
}

bool km_nearest_configuration_reserve(km_nearest_configuration *c, const km_mechanism *m, const km_substructure *sub,
                                      km_arena *arena) {
  *c = (km_nearest_configuration){.size = sub->columns + sub->rows,
                                  .hessian_count = km_loops_hessian_entries(m, sub, NULL)};
  size_t size = (size_t)c->size;
  c->hessian = KM_ARENA_NEW(arena, double, (size_t)c->hessian_count + 1);
  c->hessian_diagonal = KM_ARENA_NEW(arena, double, (size_t)sub->columns);
  c->displacement = KM_ARENA_NEW(arena, double, (size_t)sub->columns);
  c->next_displacement = KM_ARENA_NEW(arena, double, (size_t)sub->columns);
  c->b = KM_ARENA_NEW(arena, double, size);
  c->x = KM_ARENA_NEW(arena, double, size);
  c->fixed = KM_ARENA_NEW(arena, bool, size);
  if (create_pattern(c, m, sub, arena))
    c->factor = km_factor_create_sparse(c->size, c->size, c->start, c->row, NULL, arena);
  return c->factor != NULL;
}

/* Sets the fixed unknowns. */
static void set_fixed(km_nearest_configuration *c, const km_substructure *sub, int driver, const bool *locked,
                      const km_factor *pivots) {
  for (int i = 0; i < c->size; ++i)
    c->fixed[i] = i >= sub->columns || i == driver || (locked && locked[i]);
  for (int i = 0; i < km_factor_rank(pivots); ++i)
    c->fixed[sub->columns + km_factor_row_order(pivots)[i]] = false;
}

/* Adds to an entry of K. Rows of fixed unknowns are omitted: their diagonal 1 makes the unknown 0. */
static void add_entry(km_nearest_configuration *c, int at, double value) {
  if (!c->fixed[c->row[at]])
    c->value[at] += value;
}

/* Assembles K with the Hessian of the closure at the multipliers λ. */
static void assemble_matrix(km_nearest_configuration *c, const km_mechanism *m, km_state *s, const km_substructure *sub,
                            const double *lambda) {
  const double *weight = m->column_weight + sub->column_start, *J = km_state_jacobian(s, sub);
  km_loops_hessian(m, s, sub, lambda, c->hessian, c->hessian_diagonal);
  memset(c->value, 0, (size_t)c->start[c->size] * sizeof *c->value);
  for (int i = 0; i < 2 * c->hessian_count; ++i)
    add_entry(c, c->hessian_index[i], -c->hessian[i / 2]);
  for (size_t i = 0; i < sub->pattern.size; ++i) {
    add_entry(c, c->J_index[i], J[i]);
    add_entry(c, c->transposed_index[i], -J[i]);
  }
  for (int i = 0; i < c->size; ++i)
    if (c->fixed[i])
      c->value[c->diagonal_index[i]] = 1.0;
    else if (i < sub->columns)
      c->value[c->diagonal_index[i]] += weight[i] * weight[i] - c->hessian_diagonal[i];
}

/* Factors K, with the previous pivots if the growth monitor accepts them, and solves K x = b. */
static bool factor_and_solve(km_nearest_configuration *c) {
  if (km_factor_rank(c->factor) != c->size || !km_factor_refactor(c->factor, c->value, KM_BASIS_ENTRIES))
    km_factor_compute(c->factor, c->value, c->size, c->size, &(km_factor_options){.basis = KM_BASIS_ENTRIES});
  bool is_regular = !km_factor_has_failed(c->factor) && km_factor_rank(c->factor) == c->size;
  if (is_regular)
    km_factor_solve(c->factor, c->b, c->x);
  return is_regular;
}

/* Newton's method on the Karush-Kuhn-Tucker conditions of min |D (x − y)|² with e(x) = 0. */
bool km_nearest_configuration_find(km_nearest_configuration *c, const km_mechanism *m, km_state *s, int index,
                                   int driver, const km_factor *pivots, double *displacement) {
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start, *error = km_state_error(s, sub);
  double *lambda = c->x + sub->columns, largest = HUGE_VAL;
  bool is_converged = false;
  set_fixed(c, sub, driver, km_state_locked_columns(s, index), pivots);
  memset(c->x, 0, (size_t)c->size * sizeof *c->x);
  for (int pass = 0; pass <= MAX_ITERATIONS && !is_converged; ++pass) {
    km_loops_recompute(m, s, sub);
    assemble_matrix(c, m, s, sub, lambda);
    for (int i = 0; i < c->size; ++i)
      c->b[i] = c->fixed[i]        ? 0.0
                : i < sub->columns ? -weight[i] * weight[i] * displacement[i]
                                   : -error[i - sub->columns];
    memset(c->x, 0, (size_t)sub->columns * sizeof *c->x); /* δ restarts at 0; the multipliers of the last pass are good
                                                           * starts */
    if (!factor_and_solve(c))
      return false;
    if (pass == 0) /* the first solution supplies λ only; without λ the step would omit the Hessian */
      continue;
    double last = largest;
    largest = km_max_norm(c->x, sub->columns);
    /* Steps stagnate near singular configurations: the loops are nearly indifferent to the remainder. */
    is_converged = largest <= 0.1 * km_relative_zero || (largest <= 10.0 * km_relative_zero && largest > 0.25 * last);
    if (!isfinite(largest) || (!is_converged && largest > 2.0 * last))
      return false;
    double share = largest > km_max_newton_step ? km_max_newton_step / largest : 1.0;
    for (int k = 0; k < sub->columns; ++k)
      displacement[k] += c->x[k] *= share;
    km_state_move(m, s, sub, c->x);
  }
  return is_converged;
}

/* Solves K (δ, λ) = (D² step, 0): linear response of the nearest configuration. */
void km_nearest_configuration_follow(km_nearest_configuration *c, const km_mechanism *m, const km_substructure *sub,
                                     double *step) {
  const double *weight = m->column_weight + sub->column_start;
  memset(c->b, 0, (size_t)c->size * sizeof *c->b);
  for (int k = 0; k < sub->columns; ++k)
    c->b[k] = c->fixed[k] ? 0.0 : weight[k] * weight[k] * step[k];
  km_factor_solve(c->factor, c->b, c->x);
  memcpy(step, c->x, (size_t)sub->columns * sizeof *step);
}
