/* Local analysis: first order, and tangents by coefficients of either back end (docs/theory.md 5.1, 5.5).
 *
 *   basis   : x = D⁻¹ Z a,   a = Zᵀ D x
 *   columns : x = D⁻¹ a,     a = P D x,   P the projector onto D null(J), by minimum-norm steps */
#include "local/local_private.h"

#include "base/random.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/second_order_columns.h"

#include <string.h>

/* More freedoms without passive ones have families of branches, each of which would be followed. */
enum { MAX_FOLLOWED_FREEDOM = 3 };

/* True if the freedoms and rows are few enough for a basis. */
static bool is_basis_affordable(const km_local *l) {
  int k = l->freedom;
  return k <= 1 || (k <= KM_MAX_BASIS_FREEDOM && km_local_is_small(l->sub)) ||
         (k <= KM_MANY_VECTORS && k - l->known_passive <= MAX_FOLLOWED_FREEDOM);
}

km_local *km_local_create(const km_mechanism *m, km_state *s, int index, const km_passive_freedoms *passive,
                          double min_tolerance, km_arena *arena) {
  const km_substructure *sub = &m->substructures[index];
  km_local *l = KM_ARENA_NEW(arena, km_local, 1);
  if (!l)
    return NULL;
  km_loops_update(m, s, sub);
  *l = (km_local){.m = m,
                  .s = s,
                  .index = index,
                  .sub = sub,
                  .weight = m->column_weight + sub->column_start,
                  .arena = arena,
                  .passive = passive,
                  .residual = km_loops_residual(m, s, sub),
                  .min_verdict = KM_TANGENT_CONFIRMED,
                  .random = 1};
  l->tolerance = fmax(km_rank_tolerance(m, sub, l->residual), min_tolerance);
  l->noise = fmax(1e-7, 100.0 * l->residual);
  km_search_rank(m, s, index, l->tolerance);
  l->freedom = km_factor_freedom(s->factor[index]);
  l->has_redundant_rows = km_factor_rank(s->factor[index]) < sub->rows;
  for (int i = 0; passive && i < passive->count; ++i)
    l->known_passive += passive->items[i].substructure == index ? passive->items[i].freedoms : 0;
  l->has_basis = is_basis_affordable(l);
  l->origin = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *(size_t)sub->columns);
  l->last = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *(size_t)sub->columns);
  l->end_ahead = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *(size_t)sub->columns);
  double **vectors[] = {&l->chord, &l->secant, &l->move, &l->tangent, &l->direction};
  for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
    *vectors[i] = KM_ARENA_NEW(arena, double, (size_t)sub->columns);
  arena->failed = arena->failed || km_factor_has_failed(s->factor[index]);
  if (arena->failed)
    return NULL;
  km_state_save(s, sub, l->origin);
  return l;
}

void km_local_restore(km_local *l) {
  if (l)
    km_loops_restore_cached(l->m, l->s, l->index, l->origin);
}

void km_local_free(km_local *l) {
  if (l)
    km_second_order_columns_free(l->columns);
}

bool km_local_has_full_row_rank(const km_local *l) {
  return !l->has_redundant_rows;
}

bool km_local_reserve_tangents(km_local *l, bool with_basis) {
  size_t k = (size_t)l->freedom, n = (size_t)l->sub->columns;
  if (l->a)
    return true;
  l->has_basis = with_basis;
  l->size = (int)(with_basis ? k : n);
  l->a = KM_ARENA_NEW(l->arena, double, (size_t)l->size);
  l->previous = KM_ARENA_NEW(l->arena, double, (size_t)l->size);
  l->work = KM_ARENA_NEW(l->arena, double, with_basis ? 4 * k *k + 8 * k : n);
  const double *Z = with_basis ? km_factor_null_space(l->s->factor[l->index], l->freedom) : NULL;
  if (Z && (l->Z = KM_ARENA_NEW(l->arena, double, k *n)))
    memcpy(l->Z, Z, k * n * sizeof *Z);
  l->arena->failed = l->arena->failed || (with_basis && !Z);
  return !l->arena->failed;
}

void km_local_return(km_local *l) {
  if (l->s->pivot_driver[l->index] == KM_NO_DRIVER && km_state_is_at(l->s, l->sub, l->origin))
    return;
  km_state_restore(l->s, l->sub, l->origin);
  km_loops_update(l->m, l->s, l->sub);
  km_search_rank(l->m, l->s, l->index, l->tolerance);
}

void km_local_direction(const km_local *l, const double *a, double *x) {
  int n = l->sub->columns;
  for (int c = 0; c < n; ++c) {
    x[c] = l->has_basis ? 0.0 : a[c];
    for (int i = 0; i < l->freedom && l->has_basis; ++i)
      x[c] += l->Z[(size_t)i * (size_t)n + (size_t)c] * a[i];
    x[c] /= l->weight[c];
  }
}

/* x minus its minimum-norm part: projection onto the null space of J, normalised. */
double km_tangent_project(const km_mechanism *m, km_state *s, int index, double *x, double *projection) {
  const km_substructure *sub = &m->substructures[index];
  const bool *locked = km_state_locked_columns(s, index);
  for (int c = 0; c < sub->columns; ++c) {
    x[c] = locked && locked[c] ? 0.0 : x[c];
    projection[c] = x[c];
  }
  km_minimum_norm_step(m, s, index, KM_NO_DRIVER, projection);
  for (int c = 0; c < sub->columns; ++c)
    x[c] -= projection[c];
  double length = km_step_length(m, sub, x);
  for (int c = 0; c < sub->columns; ++c)
    x[c] /= length;
  return length;
}

double km_local_normalise(km_local *l, double *a) {
  double length = 0.0;
  if (l->has_basis) {
    for (int i = 0; i < l->size; ++i)
      length += a[i] * a[i];
    length = sqrt(length);
    for (int i = 0; i < l->size; ++i)
      a[i] /= length;
  } else {
    km_local_return(l);
    km_local_direction(l, a, a);
    length = km_tangent_project(l->m, l->s, l->index, a, l->work);
    for (int c = 0; c < l->size; ++c)
      a[c] *= l->weight[c];
  }
  return isfinite(length) ? length : 0.0;
}

double km_local_coefficients(km_local *l, const double *x, double *a) {
  int n = l->sub->columns;
  for (int i = 0; i < l->size; ++i) {
    a[i] = l->has_basis ? 0.0 : l->weight[i] * x[i];
    for (int c = 0; c < n && l->has_basis; ++c)
      a[i] += l->Z[(size_t)i * (size_t)n + (size_t)c] * l->weight[c] * x[c];
  }
  return km_local_normalise(l, a);
}

bool km_local_draw(km_local *l, uint64_t *random, double *a) {
  for (int i = 0; i < l->size; ++i)
    a[i] = km_uniform(random);
  return km_local_normalise(l, a) > 0.0;
}

bool km_local_is_same(const km_local *l, const double *a, const double *b, double tolerance) {
  double cosine = 0.0;
  for (int i = 0; i < l->size; ++i)
    cosine += a[i] * b[i];
  return 1.0 - fabs(cosine) <= tolerance;
}
