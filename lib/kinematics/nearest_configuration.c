/* Closest poses by Newton's method with the loops' bend. */
#include "kinematics/nearest_configuration.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_ITERATIONS = 12 };
static const double nowhere = 1e-10; /* behind a smaller step Newton's method leaves rounding alone */
static const double rounding =
    1e-8; /* the same, where steps don't shrink any more: the loops hardly tell it from others */

/* Entries of the matrix as column · size + row, in the order in which they were listed. */
typedef struct listing {
  int64_t *keys;
  int count, size;
} listing;

static int add(listing *l, int row, int column) {
  l->keys[l->count] = (int64_t)column * l->size + row;
  return l->count++;
}

static int ascending(const void *a, const void *b) {
  int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
  return (x > y) - (x < y);
}

/* All entries of the matrix, some of them several times. */
static void list_entries(const km_substructure *sub, const int *pairs, int pair_count, listing *l) {
  const km_pattern *pattern = &sub->pattern;
  for (int i = 0; i < pair_count; ++i) {
    add(l, pairs[2 * i], pairs[2 * i + 1]);
    add(l, pairs[2 * i + 1], pairs[2 * i]);
  }
  for (int c = 0; c < sub->columns; ++c) {
    int first = pattern->start ? pattern->start[c] : c * sub->rows;
    int end = pattern->start ? pattern->start[c + 1] : first + sub->rows;
    for (int i = first; i < end; ++i) {
      int row = sub->columns + (pattern->start ? pattern->row[i] : i - first);
      add(l, row, c);
      add(l, c, row);
    }
  }
  for (int i = 0; i < l->size; ++i)
    add(l, i, i);
}

/* Where an entry is among those that differ. */
static int place_of(int64_t key, const int64_t *keys, int count) {
  const int64_t *at = bsearch(&key, keys, (size_t)count, sizeof key, ascending);
  return (int)(at - keys);
}

/* The places of the listed entries, and the pattern that they make. */
static void compress(km_nearest_configuration *c, const km_substructure *sub, const listing *l, int64_t *sorted) {
  int count = 0, next = 0, entries = (int)sub->pattern.size;
  memcpy(sorted, l->keys, (size_t)l->count * sizeof *sorted);
  qsort(sorted, (size_t)l->count, sizeof *sorted, ascending);
  for (int i = 0; i < l->count; ++i)
    if (i == 0 || sorted[i] != sorted[count - 1])
      sorted[count++] = sorted[i];
  for (int i = 0; i < count; ++i) {
    c->row[i] = (int)(sorted[i] % l->size);
    c->start[sorted[i] / l->size + 1] = i + 1;
  }
  for (int i = 0; i < 2 * c->hessian_count; ++i)
    c->hessian_index[i] = place_of(l->keys[next++], sorted, count);
  for (int i = 0; i < entries; ++i) {
    c->J_index[i] = place_of(l->keys[next++], sorted, count);
    c->transposed_index[i] = place_of(l->keys[next++], sorted, count);
  }
  for (int i = 0; i < c->size; ++i)
    c->diagonal_index[i] = place_of(l->keys[next++], sorted, count);
}

static bool make_pattern(km_nearest_configuration *c, const km_mechanism *m, const km_substructure *sub,
                         km_arena *arena) {
  size_t most = 2 * (size_t)c->hessian_count + 2 * sub->pattern.size + (size_t)c->size;
  km_arena scratch = {0};
  int *pairs = KM_ARENA_NEW(&scratch, int, 2 * (size_t)c->hessian_count + 1);
  int64_t *sorted = KM_ARENA_NEW(&scratch, int64_t, most);
  listing l = {.keys = KM_ARENA_NEW(&scratch, int64_t, most), .size = c->size};
  c->start = KM_ARENA_NEW(arena, int, (size_t)c->size + 1);
  c->row = KM_ARENA_NEW(arena, int, most);
  c->value = KM_ARENA_NEW(arena, double, most);
  c->hessian_index = KM_ARENA_NEW(arena, int, 2 * (size_t)c->hessian_count + 1);
  c->J_index = KM_ARENA_NEW(arena, int, sub->pattern.size);
  c->transposed_index = KM_ARENA_NEW(arena, int, sub->pattern.size);
  c->diagonal_index = KM_ARENA_NEW(arena, int, (size_t)c->size);
  bool made = !scratch.failed && !arena->failed;
  if (made) {
    km_loops_hessian_entries(m, sub, pairs);
    list_entries(sub, pairs, c->hessian_count, &l);
    compress(c, sub, &l, sorted);
  }
  km_arena_free(&scratch);
  return made;
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
  c->residual = KM_ARENA_NEW(arena, double, size);
  c->correction = KM_ARENA_NEW(arena, double, size);
  c->fixed = KM_ARENA_NEW(arena, bool, size);
  c->fixed_next = KM_ARENA_NEW(arena, bool, size);
  if (!make_pattern(c, m, sub, arena) ||
      !km_partition_reserve_sparse(&c->factor, c->size, c->size, c->start, c->row, arena))
    return false;
  c->factor.unrestricted_basis = true;
  return true;
}

static void fix(km_nearest_configuration *c, const km_substructure *sub, int driver, const bool *locked,
                const km_partition *pivots) {
  bool *before = c->fixed, *now = c->fixed_next;
  for (int i = 0; i < c->size; ++i)
    now[i] = i >= sub->columns || i == driver || (locked && locked[i]);
  for (int i = 0; i < pivots->rank; ++i)
    now[sub->columns + pivots->row[i]] = false;
  c->is_factored = c->is_factored && memcmp(before, now, (size_t)c->size * sizeof *now) == 0;
  c->fixed = now;
  c->fixed_next = before;
}

/* Fixed rows say that their unknown is 0. */
static void put(km_nearest_configuration *c, int at, double value) {
  if (!c->fixed[c->row[at]])
    c->value[at] += value;
}

/* The matrix with the bend by the multipliers λ. */
static void fill(km_nearest_configuration *c, const km_mechanism *m, km_state *s, const km_substructure *sub,
                 const double *lambda) {
  const double *weight = m->column_weight + sub->column_start, *J = km_state_jacobian(s, sub);
  km_loops_hessian(m, s, sub, lambda, c->hessian, c->hessian_diagonal);
  c->is_current = false;
  memset(c->value, 0, (size_t)c->start[c->size] * sizeof *c->value);
  for (int i = 0; i < 2 * c->hessian_count; ++i)
    put(c, c->hessian_index[i], -c->hessian[i / 2]);
  for (size_t i = 0; i < sub->pattern.size; ++i) {
    put(c, c->J_index[i], J[i]);
    put(c, c->transposed_index[i], -J[i]);
  }
  for (int i = 0; i < c->size; ++i)
    if (c->fixed[i])
      c->value[c->diagonal_index[i]] = 1.0;
    else if (i < sub->columns)
      c->value[c->diagonal_index[i]] += weight[i] * weight[i] - c->hessian_diagonal[i];
}

/* NaN where one of them is no number. */
static double largest_of(const double *x, int count) {
  double largest = 0.0;
  for (int i = 0; i < count; ++i)
    largest = km_larger_or_nan(fabs(x[i]), largest);
  return largest;
}

/* Solves by the factor of a matrix before, from the x at hand: what the solution leaves of b is solved again until rounding is left.
 * False where that takes long, since the matrix has changed too much. */
static bool correct(km_nearest_configuration *c) {
  enum { MOST_CORRECTIONS = 6 };
  static const double grain = 1e-14, coarse_grain = 1e-10, most_share = 0.05;
  double last = HUGE_VAL;
  for (int pass = 0; pass < MOST_CORRECTIONS; ++pass) {
    memcpy(c->residual, c->b, (size_t)c->size * sizeof *c->residual);
    for (int k = 0; k < c->size; ++k)
      for (int i = c->start[k]; i < c->start[k + 1]; ++i)
        c->residual[c->row[i]] -= c->value[i] * c->x[k];
    km_partition_solve(&c->factor, c->residual, c->correction);
    for (int k = 0; k < c->size; ++k)
      c->x[k] += c->correction[k];
    double size = largest_of(c->correction, c->size), all = largest_of(c->x, c->size);
    if (size <= grain * all)
      return true;
    if (!(size <= most_share * last)) /* among rounding alone nothing shrinks */
      return size <= coarse_grain * all;
    last = size;
  }
  return false;
}

/* Does a factor take as long as all corrections that may be tried? Little fills in where the loops make a chain. */
static bool is_costly(const km_nearest_configuration *c) {
  static const double most = 100.0; /* multiplications of each entry of the matrix */
  return km_partition_multiplications(&c->factor) > most * c->start[c->size];
}

static bool factor(km_nearest_configuration *c) {
  if (c->factor.rank == c->size && km_partition_refactor(&c->factor, c->value))
    return true;
  km_partition_factor(&c->factor, c->value, c->size, c->size, NULL, 0.0);
  c->is_costly = is_costly(c);
  return !c->factor.failed && c->factor.rank == c->size;
}

static bool solve(km_nearest_configuration *c) {
  if (!c->is_current && c->is_factored && c->is_costly && correct(c))
    return true;
  if (!c->is_current)
    c->is_current = c->is_factored = factor(c);
  if (c->is_current)
    km_partition_solve(&c->factor, c->b, c->x);
  return c->is_current;
}

bool km_nearest_configuration_find(km_nearest_configuration *c, const km_mechanism *m, km_state *s, int index,
                                   int driver, const km_partition *pivots, double *away) {
  const km_substructure *sub = &m->substructures[index];
  const double *weight = m->column_weight + sub->column_start, *error = km_state_error(s, sub);
  double *lambda = c->x + sub->columns, largest = HUGE_VAL;
  bool settled = false;
  fix(c, sub, driver, s->partition[index].locked, pivots);
  memset(c->x, 0, (size_t)c->size * sizeof *c->x);
  for (int pass = 0; pass <= MOST_ITERATIONS && !settled; ++pass) {
    km_loops_recompute(m, s, sub);
    fill(c, m, s, sub, lambda);
    for (int i = 0; i < c->size; ++i)
      c->b[i] = c->fixed[i] ? 0.0 : i < sub->columns ? -weight[i] * weight[i] * away[i] : -error[i - sub->columns];
    memset(c->x, 0, (size_t)sub->columns * sizeof *c->x); /* the multipliers of the last pass are near these */
    if (!solve(c))
      return false;
    if (pass == 0) /* the first multipliers; without them the step knows nothing of the bend */
      continue;
    double last = largest;
    largest = largest_of(c->x, sub->columns);
    settled = largest <= nowhere || (largest <= rounding && largest > 0.25 * last);
    if (!isfinite(largest) || (!settled && largest > 2.0 * last))
      return false;
    double share = largest > km_max_newton_step ? km_max_newton_step / largest : 1.0;
    for (int k = 0; k < sub->columns; ++k)
      away[k] += c->x[k] *= share;
    km_state_move(m, s, sub, c->x);
  }
  return settled;
}

void km_nearest_configuration_follow(km_nearest_configuration *c, const km_mechanism *m, const km_substructure *sub,
                                     double *step) {
  const double *weight = m->column_weight + sub->column_start;
  memset(c->b, 0, (size_t)c->size * sizeof *c->b);
  for (int k = 0; k < sub->columns; ++k)
    c->b[k] = c->fixed[k] ? 0.0 : weight[k] * weight[k] * step[k];
  memset(c->x, 0, (size_t)c->size * sizeof *c->x);
  if (solve(c))
    memcpy(step, c->x, (size_t)sub->columns * sizeof *step);
}
