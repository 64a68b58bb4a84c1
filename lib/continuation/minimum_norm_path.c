/* Follows the direction field of least motion, dq/ds = t(q), to a higher order than the field's own rows ask. */
#include "continuation/minimum_norm_path.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

/* The rounding of a step near singular poses, where closed loops tell it to no more digits. It decays on a path that is stiff. */
static const double coarse_grain = 1e-9;

const double km_path_stage_shares[KM_PATH_STAGES][KM_PATH_STAGES - 1] = {
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

/* The rate of the rotation vector u whose turn has the angular velocity w (fixed axes):
 * u̇ = w − ½ u × w + c u × (u × w), c = 1/θ² − (1 + cos θ)/(2 θ sin θ). */
static km_vec3 vector_rate(km_vec3 u, km_vec3 w) {
  double angle = km_vec3_norm(u), square = angle * angle, sine, cosine;
  km_sincos(angle, &sine, &cosine);
  double c = angle < KM_PATH_NEAR ? 1.0 / 12 + square / 720 : 1.0 / square - (1.0 + cosine) / (2.0 * angle * sine);
  km_vec3 once = km_vec3_cross(u, w), twice = km_vec3_cross(u, once);
  return km_vec3_axpy(c, twice, km_vec3_axpy(-0.5, once, w));
}

/* Angular velocities of balls become rates of the rotation vectors that lead from the saved pose. */
static void unwind_balls(const km_mechanism *m, const km_substructure *sub, const double *move, double *rate) {
  const int *coordinate = m->column_coordinate + sub->column_start;
  for (int k = 0; k < sub->columns; ++k) {
    if (m->ball_of[coordinate[k]] < 0)
      continue;
    km_vec3 v = vector_rate(km_vec3_make(move + k), km_vec3_make(rate + k));
    memcpy(rate + k, &(double[3]){v.x, v.y, v.z}, 3 * sizeof *rate);
    k += 2;
  }
}

static void combine(const km_minimum_norm_path *path, const double *share, int stages, int columns, double h,
                    double *move) {
  memset(move, 0, (size_t)columns * sizeof *move);
  for (int i = 0; i < stages; ++i)
    for (int k = 0; k < columns && share[i] != 0.0; ++k)
      move[k] += h * share[i] * path->rate[i][k];
}

/* The field off the closed poses is that of the primary rows: they keep what the loops have opened. `again`: the last rate was
 * found by these pivots, which are at hand still if they have only waited. */
static bool rate_at(const km_mechanism *m, km_state *s, int index, int driver, const km_partition *pivots, bool again,
                    double *rate) {
  const km_substructure *sub = &m->substructures[index];
  km_partition *p = &s->partition[index];
  km_loops_recompute(m, s, sub);
  if (!again || !p->is_deferred)
    km_partition_copy_pivots(p, pivots);
  if (!km_defer_pivots(s, index, driver) && !km_partition_refactor_full_pattern(p, km_state_jacobian(s, sub)))
    return false;
  km_minimum_norm_rates(m, s, index, driver, rate);
  return true;
}

static double largest(const double *x, int count) {
  double size = 0.0;
  for (int k = 0; k < count; ++k)
    size = fmax(size, fabs(x[k]));
  return size;
}

double km_minimum_norm_path_predict(km_minimum_norm_path *path, const km_mechanism *m, km_state *s, int index,
                                    int driver, const km_partition *pivots, const double *saved, const double *t,
                                    double h, double *move) {
  const km_substructure *sub = &m->substructures[index];
  int columns = sub->columns;
  double difference[KM_PATH_STAGES];
  memcpy(path->rate[0], t, (size_t)columns * sizeof *t);
  km_state_invalidate_pivots(s, index);
  for (int i = 1; i < KM_PATH_STAGES; ++i) {
    combine(path, km_path_stage_shares[i], i, columns, h, move);
    if (!(largest(move, columns) <= 1.0)) /* too far for the field to mean anything */
      return HUGE_VAL;
    km_state_restore(s, sub, saved);
    km_state_move_temporarily(m, s, sub, move);
    if (!rate_at(m, s, index, driver, pivots, i > 1, path->rate[i]))
      return HUGE_VAL;
    unwind_balls(m, sub, move, path->rate[i]);
  }
  for (int i = 0; i < KM_PATH_STAGES; ++i)
    difference[i] = km_path_fifth[i] - km_path_fourth[i];
  combine(path, difference, KM_PATH_STAGES, columns, h, move);
  double error = largest(move, columns);
  combine(path, km_path_fifth, KM_PATH_STAGES, columns, h, move);
  km_partition_copy_pivots(&s->partition[index], pivots);
  s->pivot_driver[index] = driver;
  return error / (km_path_allowed * largest(move, columns) + km_path_grain);
}

/* The weights w with Σ w_k x_k^j = moment_j, j = 0 … count-1, in place of the moments. Å. Björck and V. Pereyra, Solution of
 * Vandermonde systems of equations, 1970. */
static void weigh_nodes(const double *x, int count, double *moment) {
  for (int k = 0; k < count - 1; ++k)
    for (int i = count - 1; i > k; --i)
      moment[i] -= x[k] * moment[i - 1];
  for (int k = count - 2; k >= 0; --k) {
    for (int i = k + 1; i < count; ++i)
      moment[i] /= x[i] - x[i - k - 1];
    for (int i = k; i < count - 1; ++i)
      moment[i] -= moment[i + 1];
  }
}

/* Tangents at the nodes x, counted from the pose in units of h. */
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

static km_vec3 weighted_turn(const nodes *n, const double *weight, int column) {
  km_vec3 sum = {0, 0, 0};
  for (int i = 0; i < n->count; ++i)
    sum = km_vec3_axpy(weight[i], km_vec3_make(n->t[i] + column), sum);
  return sum;
}

/* A ball's rotation vector isn't the integral of its angular velocity ω, which turns itself. By the series of W. Magnus,
 * 1954, u = ∫ω − h³/12 ω × ω̇ − h⁴/24 ω × ω̈ + O(h⁵). */
static void wind_balls(const km_mechanism *m, const km_substructure *sub, const nodes *n, double h, double *move) {
  const int *coordinate = m->column_coordinate + sub->column_start;
  double slope[KM_PATH_NODES] = {0.0, 1.0}, bend[KM_PATH_NODES] = {0.0, 0.0, 2.0};
  weigh_nodes(n->x, n->count, slope);
  weigh_nodes(n->x, n->count, bend);
  for (int k = 0; k < sub->columns; ++k) {
    if (m->ball_of[coordinate[k]] < 0)
      continue;
    km_vec3 change = km_vec3_axpy(0.5, weighted_turn(n, bend, k), weighted_turn(n, slope, k));
    km_vec3 lag = km_vec3_scale(-h * h / 12.0, km_vec3_cross(km_vec3_make(n->t[0] + k), change));
    move[k] += lag.x;
    move[k + 1] += lag.y;
    move[k + 2] += lag.z;
    k += 2;
  }
}

double km_minimum_norm_path_continue(const km_mechanism *m, const km_substructure *sub, const km_step_history *c,
                                     double h, double *move) {
  if (c->last_h == 0.0 || 2 + c->older_count < KM_PATH_LEAST_NODES)
    return HUGE_VAL;
  nodes n = gather_nodes(c, h);
  double whole[KM_PATH_NODES], less[KM_PATH_NODES] = {0.0}, error = 0.0;
  for (int i = 0; i < n.count; ++i) /* moments of [0, 1] */
    whole[i] = less[i] = 1.0 / (i + 1);
  less[n.count - 1] = 0.0;
  weigh_nodes(n.x, n.count, whole);
  weigh_nodes(n.x, n.count - 1, less);
  for (int k = 0; k < sub->columns; ++k) {
    double sum = 0.0, apart = 0.0;
    for (int i = 0; i < n.count; ++i) {
      sum += whole[i] * n.t[i][k];
      apart += (whole[i] - less[i]) * n.t[i][k];
    }
    move[k] = h * sum;
    error = km_larger_or_nan(fabs(h * apart), error);
  }
  wind_balls(m, sub, &n, h, move);
  return error / (km_path_allowed * largest(move, sub->columns) + km_path_grain);
}

double km_minimum_norm_path_record(km_nearest_configuration *closest, const km_mechanism *m, km_state *s, int index,
                                   int driver, const km_step_history *c, double h, double *move) {
  const km_substructure *sub = &m->substructures[index];
  int columns = sub->columns;
  double ratio = c->last_h != 0.0 ? h / c->last_h : 0.0, error = 0.0;
  bool second = ratio > 0.0 && ratio <= km_continuation_farther;
  double back = second ? ratio * ratio / (1.0 + 2.0 * ratio) : 0.0;  /* of the last move, where the way counts from */
  double share = second ? (1.0 + ratio) / (2.0 + 3.0 * ratio) : 0.5; /* of the difference, that is the step's error */
  double *away = closest->displacement, *ahead = closest->next_displacement;
  for (int k = 0; k < columns; ++k) {
    double bend = second ? ratio * (c->last_h * c->t[k] - c->last_move[k]) * ratio : 0.0;
    ahead[k] = h * c->t[k] + bend;
    away[k] = ahead[k] - (second ? back * c->last_move[k] : 0.0);
  }
  km_state_move(m, s, sub, ahead);
  if (!km_nearest_configuration_find(closest, m, s, index, driver, &c->reference, away))
    return HUGE_VAL;
  for (int k = 0; k < columns; ++k) {
    move[k] = away[k] + (second ? back * c->last_move[k] : 0.0);
    ahead[k] = share * (move[k] - ahead[k]);
  }
  /* A deviation that decays shows in the difference more often than it is left in the step, by the square of how much it is
   * drawn in. */
  for (int i = 0; i < 2; ++i)
    km_nearest_configuration_follow(closest, m, sub, ahead);
  for (int k = 0; k < columns; ++k)
    error = fabs(ahead[k]) <= error ? error : fabs(ahead[k]);
  return error / (km_path_allowed * largest(move, columns) + coarse_grain);
}
