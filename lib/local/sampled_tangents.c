/* Directions in the null space of many freedoms: random ones, those of second order, and which of them are real. */
#include "local/sampled_tangents.h"

#include "base/random.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

/* More freedoms have too many branches to be listed, and the dense conditions of more rows take too long. */
enum { MOST_ROWS = 240 };
/* So many starts times columns are sought for: each takes a few dozen sparse factorisations. */
enum { MOST_WORK = 1200, LEAST_STARTS = 2 };
enum { TRIALS = 2 }; /* random directions that show that all are real */

bool km_tangents_are_many(const km_tangents *f) {
  int freedom = f->conditions.freedom;
  return freedom > 1 && (freedom > KM_MAX_BASIS_FREEDOM || f->sub->rows > MOST_ROWS);
}

bool km_sampled_tangents_create(km_sampled_tangents *many, km_tangents *f) {
  int starts = MOST_WORK / f->sub->columns;
  *many = (km_sampled_tangents){.f = f,
                                .max_starts = starts > LEAST_STARTS ? starts : LEAST_STARTS,
                                .x = KM_ARENA_NEW(f->arena, double, (size_t)f->sub->columns),
                                .projection = KM_ARENA_NEW(f->arena, double, (size_t)f->sub->columns)};
  return !f->arena->failed;
}

void km_sampled_tangents_free(km_sampled_tangents *many) {
  km_second_order_columns_free(&many->conditions);
}

static void return_to_pose(const km_tangents *f) {
  km_state_restore(f->s, f->sub, f->origin);
  km_loops_update(f->m, f->s, f->sub);
  km_search_pivots(f->m, f->s, f->index, KM_NO_DRIVER, f->conditions.tolerance);
}

double km_tangent_project(const km_mechanism *m, km_state *s, int index, double *x, double *part) {
  const km_substructure *sub = &m->substructures[index];
  const bool *locked = s->partition[index].locked;
  for (int c = 0; c < sub->columns; ++c) {
    x[c] = locked && locked[c] ? 0.0 : x[c];
    part[c] = x[c];
  }
  km_minimum_norm_step(m, s, index, KM_NO_DRIVER, part);
  for (int c = 0; c < sub->columns; ++c)
    x[c] -= part[c];
  double length = km_step_length(m, sub, x);
  for (int c = 0; c < sub->columns; ++c)
    x[c] /= length;
  return length;
}

static bool project(km_sampled_tangents *many) {
  const km_tangents *f = many->f;
  return_to_pose(f);
  double length = km_tangent_project(f->m, f->s, f->index, many->x, many->projection);
  return isfinite(length) && length > 0.0;
}

bool km_sampled_tangents_draw(km_sampled_tangents *many) {
  const double *weight = many->f->m->column_weight + many->f->sub->column_start;
  for (int c = 0; c < many->f->sub->columns; ++c)
    many->x[c] = km_uniform(&many->f->random) / weight[c];
  return project(many);
}

/* The conditions of second order at the pose, found when they are first asked for. */
static bool need_conditions(km_sampled_tangents *many) {
  const km_tangents *f = many->f;
  km_error error;
  if (many->has_conditions)
    return many->conditions.q != NULL;
  many->has_conditions = true;
  km_status status = km_second_order_columns_create(f->m, f->s, f->index, f->conditions.tolerance, f->arena,
                                                    &many->conditions, &error);
  f->arena->failed = f->arena->failed || status == KM_MEMORY;
  return !status;
}

/* Shows the second order, before a single step, that the direction isn't real? Where following takes longer than that. */
static bool is_refuted(km_sampled_tangents *many) {
  return many->f->conditions.has_redundant_rows && many->f->conditions.freedom > KM_MANY_VECTORS &&
         need_conditions(many) && km_second_order_columns_refutes(&many->conditions, many->x);
}

bool km_sampled_tangents_draw_second_order(km_sampled_tangents *many) {
  const double *weight = many->f->m->column_weight + many->f->sub->column_start;
  if (!km_sampled_tangents_draw(many))
    return false;
  if (!is_refuted(many))
    return true;
  for (int c = 0; c < many->f->sub->columns; ++c)
    many->x[c] = (1.0 + 0.3 * km_uniform(&many->f->random)) / weight[c];
  return project(many) && km_second_order_columns_solve(&many->conditions, many->x);
}

bool km_sampled_tangents_all_finite(km_sampled_tangents *many, double *length) {
  int trials = many->f->conditions.has_redundant_rows ? TRIALS : 1; /* where nothing is redundant all are real anyway */
  *length = HUGE_VAL;
  for (int trial = 0; trial < trials; ++trial) {
    if (!km_sampled_tangents_draw(many) || is_refuted(many))
      return false;
    km_followed_tangent found = km_tangents_follow_both_senses(many->f, many->x);
    if (found.verdict < many->f->min_verdict)
      return false;
    if (many->f->conditions.has_redundant_rows &&
        (!km_tangents_secant_agrees(many->f, many->x) || km_tangents_have_dropped(many->f)))
      return false;
    *length = fmin(*length, found.length);
  }
  return true;
}

/* The first start is even: neighbouring loops that are alike move alike then, and none of them runs away from the others. */
static bool begin(km_sampled_tangents *many) {
  const double *weight = many->f->m->column_weight + many->f->sub->column_start;
  if (many->starts++ > 0)
    return km_sampled_tangents_draw(many);
  for (int c = 0; c < many->f->sub->columns; ++c)
    many->x[c] = 1.0 / weight[c];
  return project(many);
}

bool km_sampled_tangents_find_next(km_sampled_tangents *many, double *length) {
  while (many->starts < many->max_starts) {
    if (!begin(many) || !need_conditions(many) || !km_second_order_columns_solve(&many->conditions, many->x))
      continue;
    km_followed_tangent found = km_tangents_follow_both_senses(many->f, many->x);
    *length = found.length;
    if (found.verdict >= many->f->min_verdict)
      return true;
  }
  return false;
}
