/* Random tangents of a substructure with many freedoms, and tangents that satisfy the second order (docs/theory.md
 * 5.5). */
#include "local/sampled_tangents.h"

#include "base/random.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

/* More rows make the dense second-order conditions too expensive. */
enum { MAX_DENSE_ROWS = 240 };
/* Bound of starts · columns: each start takes a few dozen sparse factorisations. */
enum { MAX_STARTS_TIMES_COLUMNS = 1200, MIN_STARTS = 2 };
enum { SAMPLES = 2 }; /* random directions that show that all tangents are finite */

bool km_tangents_are_many(const km_tangents *f) {
  int freedom = f->conditions.freedom;
  return freedom > 1 && (freedom > KM_MAX_BASIS_FREEDOM || f->sub->rows > MAX_DENSE_ROWS);
}

bool km_sampled_tangents_create(km_sampled_tangents *sample, km_tangents *f) {
  int starts = MAX_STARTS_TIMES_COLUMNS / f->sub->columns;
  *sample = (km_sampled_tangents){.f = f,
                                  .max_starts = starts > MIN_STARTS ? starts : MIN_STARTS,
                                  .x = KM_ARENA_NEW(f->arena, double, (size_t)f->sub->columns),
                                  .projection = KM_ARENA_NEW(f->arena, double, (size_t)f->sub->columns)};
  return !f->arena->failed;
}

void km_sampled_tangents_free(km_sampled_tangents *sample) {
  km_second_order_columns_free(&sample->conditions);
}

static void return_to_origin(const km_tangents *f) {
  km_state_restore(f->s, f->sub, f->origin);
  km_loops_update(f->m, f->s, f->sub);
  km_search_pivots(f->m, f->s, f->index, KM_NO_DRIVER, f->conditions.tolerance);
}

/* x minus its minimum-norm part: projection onto the null space of J, normalised. */
double km_tangent_project(const km_mechanism *m, km_state *s, int index, double *x, double *projection) {
  const km_substructure *sub = &m->substructures[index];
  const bool *locked = s->partition[index].locked;
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

/* Projects the sample onto the null space at the configuration. */
static bool project_onto_null_space(km_sampled_tangents *sample) {
  const km_tangents *f = sample->f;
  return_to_origin(f);
  double length = km_tangent_project(f->m, f->s, f->index, sample->x, sample->projection);
  return isfinite(length) && length > 0.0;
}

/* Draws a random direction and projects it onto the null space. */
bool km_sampled_tangents_draw(km_sampled_tangents *sample) {
  const double *weight = sample->f->m->column_weight + sample->f->sub->column_start;
  for (int c = 0; c < sample->f->sub->columns; ++c)
    sample->x[c] = km_uniform(&sample->f->random) / weight[c];
  return project_onto_null_space(sample);
}

/* Computes the second-order conditions of the configuration at the first call. */
static bool update_conditions(km_sampled_tangents *sample) {
  const km_tangents *f = sample->f;
  km_error error;
  if (sample->has_conditions)
    return sample->conditions.q != NULL;
  sample->has_conditions = true;
  km_status status = km_second_order_columns_create(f->m, f->s, f->index, f->conditions.tolerance, f->arena,
                                                    &sample->conditions, &error);
  f->arena->failed = f->arena->failed || status == KM_MEMORY;
  return !status;
}

/* True if the direction violates the second order. Tested only with many freedoms, where following takes longer than
 * the conditions. */
static bool violates_second_order(km_sampled_tangents *sample) {
  return sample->f->conditions.has_redundant_rows && sample->f->conditions.freedom > KM_MANY_VECTORS &&
         update_conditions(sample) && km_second_order_columns_refutes(&sample->conditions, sample->x);
}

/* Draws a random tangent; one that satisfies the second order if the first violates it. */
bool km_sampled_tangents_draw_second_order(km_sampled_tangents *sample) {
  const double *weight = sample->f->m->column_weight + sample->f->sub->column_start;
  if (!km_sampled_tangents_draw(sample))
    return false;
  if (!violates_second_order(sample))
    return true;
  for (int c = 0; c < sample->f->sub->columns; ++c)
    sample->x[c] = (1.0 + 0.3 * km_uniform(&sample->f->random)) / weight[c];
  return project_onto_null_space(sample) && km_second_order_columns_solve(&sample->conditions, sample->x);
}

/* Follows random tangents: if they are finite, all tangents are. */
bool km_sampled_tangents_all_finite(km_sampled_tangents *sample, double *length) {
  int attempts = sample->f->conditions.has_redundant_rows ? SAMPLES : 1; /* every tangent is finite if J has full row
                                                                       * rank */
  *length = HUGE_VAL;
  for (int i = 0; i < attempts; ++i) {
    if (!km_sampled_tangents_draw(sample) || violates_second_order(sample))
      return false;
    km_followed_tangent found = km_tangents_follow_both_senses(sample->f, sample->x);
    if (found.verdict < sample->f->min_verdict)
      return false;
    if (sample->f->conditions.has_redundant_rows &&
        (!km_tangents_secant_agrees(sample->f, sample->x) || km_tangents_have_dropped(sample->f)))
      return false;
    *length = fmin(*length, found.length);
  }
  return true;
}

/* The first start is uniform, so that equal loops move alike; further starts are random. */
static bool start_direction(km_sampled_tangents *sample) {
  const double *weight = sample->f->m->column_weight + sample->f->sub->column_start;
  if (sample->starts++ > 0)
    return km_sampled_tangents_draw(sample);
  for (int c = 0; c < sample->f->sub->columns; ++c)
    sample->x[c] = 1.0 / weight[c];
  return project_onto_null_space(sample);
}

/* Finds a tangent that satisfies the second order and is followed in both senses. */
bool km_sampled_tangents_find_next(km_sampled_tangents *sample, double *length) {
  while (sample->starts < sample->max_starts) {
    if (!start_direction(sample) || !update_conditions(sample) ||
        !km_second_order_columns_solve(&sample->conditions, sample->x))
      continue;
    km_followed_tangent found = km_tangents_follow_both_senses(sample->f, sample->x);
    *length = found.length;
    if (found.verdict >= sample->f->min_verdict)
      return true;
  }
  return false;
}
