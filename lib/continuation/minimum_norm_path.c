/* Predictors along the path of least motion dq/ds = t(q) (theory 4.7; equations in minimum_norm_path.h).
 *
 *   multistep      : weights of the tangents in multistep_body.h
 *   rotation vector: integral of its rate by the Magnus series */
#include "continuation/minimum_norm_path.h"
#include "base/number/tolerances.h"
#include "base/number/vectors.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

const double km_path_stage_weights[KM_PATH_STAGES][KM_PATH_STAGES - 1] = {
    {0},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {3.0 / 10, -9.0 / 10, 6.0 / 5},
    {-11.0 / 54, 5.0 / 2, -70.0 / 27, 35.0 / 27},
    {1631.0 / 55296, 175.0 / 512, 575.0 / 13824, 44275.0 / 110592, 253.0 / 4096}};
const double km_path_fifth[KM_PATH_STAGES] = {37.0 / 378, 0, 250.0 / 621, 125.0 / 594, 0, 512.0 / 1771};
const double km_path_fourth[KM_PATH_STAGES] = {2825.0 / 27648, 0,      18575.0 / 48384, 13525.0 / 55296,
                                               277.0 / 14336,  1.0 / 4};

bool km_minimum_norm_path_reserve(km_minimum_norm_path *path, int columns, km_arena *arena) {
  for (int i = 0; i < KM_PATH_STAGES; ++i)
    path->rate[i] = KM_ARENA_NEW(arena, double, (size_t)columns);
  return !arena->failed;
}

/* Converts the angular velocities of ball joints in `rate` to rates of the rotation vectors `move` from the saved
 * configuration. */
static void convert_ball_rates(const km_mechanism *m, const km_substructure *sub, const double *move, double *rate) {
  const int *coordinate = m->column_coordinate + sub->column_start;
  for (int k = 0; k < sub->columns; ++k) {
    if (m->ball_of[coordinate[k]] < 0)
      continue;
    km_vec3 v = km_rotation_vector_rate(km_vec3_from_array(move + k), km_vec3_from_array(rate + k));
    km_vec3_write(v, rate + k);
    k += 2;
  }
}

/* Computes move = h sum_i weight_i rate_i over the stages. */
static void combine_stages(const km_minimum_norm_path *path, const double *weight, int stages, int columns, double h,
                           double *move) {
  memset(move, 0, (size_t)columns * sizeof *move);
  for (int i = 0; i < stages; ++i)
    for (int k = 0; k < columns && weight[i] != 0.0; ++k)
      move[k] += h * weight[i] * path->rate[i][k];
}

/* Computes the tangent at a stage, which is not closed: that of the primary rows, which keep their closure errors. */
static bool compute_stage_rate(const km_mechanism *m, km_state *s, int index, int driver, const km_factor *pivots,
                               double *rate) {
  const km_substructure *sub = &m->substructures[index];
  km_factor *p = s->factor[index];
  km_loops_recompute(m, s, sub);
  km_factor_copy_pivots(p, pivots);
  if (!km_factor_refactor(p, km_state_jacobian(s, sub), KM_BASIS_ANY))
    return false;
  km_minimum_norm_rates(m, s, index, driver, rate);
  return true;
}

double km_minimum_norm_path_predict_runge_kutta(km_minimum_norm_path *path, const km_mechanism *m, km_state *s,
                                                int index, int driver, const km_factor *pivots, const double *saved,
                                                const double *t, double h, double *move) {
  const km_substructure *sub = &m->substructures[index];
  int columns = sub->columns;
  double difference[KM_PATH_STAGES];
  memcpy(path->rate[0], t, (size_t)columns * sizeof *t);
  km_state_invalidate_pivots(s, index);
  for (int i = 1; i < KM_PATH_STAGES; ++i) {
    combine_stages(path, km_path_stage_weights[i], i, columns, h, move);
    if (!(km_max_norm(move, columns) <= 1.0)) /* the linearisation is useless beyond 1 rad or size */
      return HUGE_VAL;
    km_state_restore(s, sub, saved);
    km_state_move_temporarily(m, s, sub, move);
    if (!compute_stage_rate(m, s, index, driver, pivots, path->rate[i]))
      return HUGE_VAL;
    convert_ball_rates(m, sub, move, path->rate[i]);
  }
  for (int i = 0; i < KM_PATH_STAGES; ++i)
    difference[i] = km_path_fifth[i] - km_path_fourth[i];
  combine_stages(path, difference, KM_PATH_STAGES, columns, h, move);
  double error = km_max_norm(move, columns);
  combine_stages(path, km_path_fifth, KM_PATH_STAGES, columns, h, move);
  km_factor_copy_pivots(s->factor[index], pivots);
  s->pivot_driver[index] = driver;
  return error / (km_path_allowed * km_max_norm(move, columns) + km_path_rounding);
}

/* Tangents t at the nodes x = (s_k − s) / h. */
typedef struct nodes {
  int count;
  double x[KM_PATH_NODES];
  const double *t[KM_PATH_NODES];
} nodes;

static nodes gather_nodes(const km_step_history *c, double h) {
  nodes n = {.count = 2 + c->older_count, .x = {0.0, -c->last_h / h}, .t = {c->t, c->last_t}};
  for (int i = 0; i < c->older_count; ++i) {
    n.x[2 + i] = n.x[1 + i] - c->older_h[i] / h;
    n.t[2 + i] = c->older_t[i];
  }
  return n;
}

static km_vec3 weighted_angular_velocity(const nodes *n, const double *weight, int column) {
  km_vec3 sum = {0, 0, 0};
  for (int i = 0; i < n->count; ++i)
    sum = km_vec3_axpy(weight[i], km_vec3_from_array(n->t[i] + column), sum);
  return sum;
}

/* Adds the terms by which the rotation vector of a ball joint differs from the integral of its angular velocity ω (W.
 * Magnus, 1954): u = ∫ω − h³/12 ω × ω̇ − h⁴/24 ω × ω̈ + O(h⁵). */
static void add_magnus_terms(const km_mechanism *m, const km_substructure *sub, const nodes *n, const km_multistep *w,
                             double h, double *move) {
  const int *coordinate = m->column_coordinate + sub->column_start;
  for (int k = 0; k < sub->columns; ++k) {
    if (m->ball_of[coordinate[k]] < 0)
      continue;
    km_vec3 change =
        km_vec3_axpy(0.5, weighted_angular_velocity(n, w->curvature, k), weighted_angular_velocity(n, w->slope, k));
    km_vec3 correction = km_vec3_scale(-h * h / 12.0, km_vec3_cross(km_vec3_from_array(n->t[0] + k), change));
    move[k] += correction.x;
    move[k + 1] += correction.y;
    move[k + 2] += correction.z;
    k += 2;
  }
}

double km_minimum_norm_path_predict_multistep(const km_mechanism *m, const km_substructure *sub,
                                              const km_step_history *c, double h, double *move) {
  if (c->last_h == 0.0 || 2 + c->older_count < KM_PATH_LEAST_NODES)
    return HUGE_VAL;
  nodes n = gather_nodes(c, h);
  const km_multistep w = km_multistep_weights(n.x, n.count, m->ball_count > 0);
  double error = 0.0;
  for (int k = 0; k < sub->columns; ++k) {
    double sum = 0.0, difference = 0.0;
    for (int i = 0; i < n.count; ++i) {
      sum += w.weight[i] * n.t[i][k];
      difference += w.error_weight[i] * n.t[i][k];
    }
    move[k] = h * sum;
    error = km_larger_or_nan(fabs(h * difference), error);
  }
  add_magnus_terms(m, sub, &n, &w, h, move);
  return error / (km_path_allowed * km_max_norm(move, sub->columns) + km_path_rounding);
}

double km_minimum_norm_path_predict_implicit(km_nearest_configuration *closest, const km_mechanism *m, km_state *s,
                                             int index, int driver, const km_step_history *c, double h, double *move) {
  const km_substructure *sub = &m->substructures[index];
  int columns = sub->columns;
  double ratio = c->last_h != 0.0 ? h / c->last_h : 0.0;
  bool has_last_step = ratio > 0.0 && ratio <= km_continuation_extrapolation_limit;
  /* backward difference: part of the last move in its origin */
  double last_move_weight = has_last_step ? ratio * ratio / (1.0 + 2.0 * ratio) : 0.0;
  /* part of the difference to the extrapolation that is the step's error */
  double error_part = has_last_step ? (1.0 + ratio) / (2.0 + 3.0 * ratio) : 0.5;
  double *target = closest->displacement, *extrapolated = closest->next_displacement;
  for (int k = 0; k < columns; ++k) {
    double curvature = has_last_step ? ratio * (c->last_h * c->t[k] - c->last_move[k]) * ratio : 0.0;
    extrapolated[k] = h * c->t[k] + curvature;
    target[k] = extrapolated[k] - (has_last_step ? last_move_weight * c->last_move[k] : 0.0);
  }
  km_state_move(m, s, sub, extrapolated);
  if (!km_nearest_configuration_find(closest, m, s, index, driver, c->reference, target))
    return HUGE_VAL;
  for (int k = 0; k < columns; ++k) {
    move[k] = target[k] + (has_last_step ? last_move_weight * c->last_move[k] : 0.0);
    extrapolated[k] = error_part * (move[k] - extrapolated[k]);
  }
  /* A decaying deviation appears in the difference but not in the step; two corrector steps remove it from the
   * estimate. */
  for (int i = 0; i < 2; ++i)
    km_nearest_configuration_follow(closest, m, sub, extrapolated);
  /* The loops determine an implicit step to the step tolerance near singular configurations; the error decays on a
   * stiff path. */
  return km_max_norm(extrapolated, columns) / (km_path_allowed * km_max_norm(move, columns) + km_relative_zero);
}
