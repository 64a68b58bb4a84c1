/* Hermite bridges over singular configurations that a driven motion crosses smoothly (theory 4.11).
 *
 * Near a rank drop the pivots are too small to determine the tangent, over a stretch of the driver s that is wide
 * where branches touch. A smooth motion has regular configurations on both sides of that stretch. Four of them with
 * their tangents, q_i and t_i at s_i = c + x_i h, x = -2, -1, 1, 2, give
 *
 *   q(s) = sum_i H_i(u) q_i + h K_i(u) t_i,   u = (s - c) / h,   error q^(8) (4 h^4)^2 / 8!  at c      (Hermite)
 *   H_i = (1 - 2 l_i'(x_i) (u - x_i)) l_i^2,  K_i = (u - x_i) l_i^2,   l_i Lagrange's polynomials
 *
 * on the stretch. The loops are then closed there by the rows that stay independent, s fixed. Two tests show that both
 * sides belong to one smooth motion: the coefficient of u^7 is of order h^7, and closing the loops at seven places of
 * |u| < 1 moves them by less than rounding does. A branch with another tangent fails the second test by a part of h,
 * one with the same tangent by a part of h^2. */
#include "continuation/driver_step.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

static const double node_x[KM_BRIDGE_NODES] = {-2.0, -1.0, 1.0, 2.0}; /* x_i */

/* Weights of the nodes' configurations and of their tangents times h. */
typedef struct hermite_weights {
  double value[KM_BRIDGE_NODES], tangent[KM_BRIDGE_NODES];
} hermite_weights;

/* l_i(u), its derivative, and l_i'(x_i). */
static void evaluate_lagrange(int i, double u, double *l, double *slope, double *slope_at_node) {
  *l = 1.0;
  *slope = *slope_at_node = 0.0;
  for (int j = 0; j < KM_BRIDGE_NODES; ++j)
    if (j != i) {
      double width = node_x[i] - node_x[j], factor = (u - node_x[j]) / width;
      *slope = *slope * factor + *l / width;
      *l *= factor;
      *slope_at_node += 1.0 / width;
    }
}

/* Computes the weights of q and of dq/du at u. */
static void compute_hermite_weights(double u, hermite_weights *value, hermite_weights *derivative) {
  for (int i = 0; i < KM_BRIDGE_NODES; ++i) {
    double l, slope, slope_at_node, distance = u - node_x[i];
    evaluate_lagrange(i, u, &l, &slope, &slope_at_node);
    value->value[i] = (1.0 - 2.0 * slope_at_node * distance) * l * l;
    value->tangent[i] = distance * l * l;
    derivative->value[i] = -2.0 * slope_at_node * l * l + 2.0 * (1.0 - 2.0 * slope_at_node * distance) * l * slope;
    derivative->tangent[i] = l * l + 2.0 * distance * l * slope;
  }
}

/* Computes the weights that give the coefficient of u^7 of the interpolant. */
static void compute_highest_coefficient_weights(hermite_weights *w) {
  for (int i = 0; i < KM_BRIDGE_NODES; ++i) {
    double leading = 1.0, slope_at_node = 0.0;
    for (int j = 0; j < KM_BRIDGE_NODES; ++j)
      if (j != i) {
        leading /= node_x[i] - node_x[j];
        slope_at_node += 1.0 / (node_x[i] - node_x[j]);
      }
    w->value[i] = -2.0 * slope_at_node * leading * leading;
    w->tangent[i] = leading * leading;
  }
}

static double *node_configuration(const km_driver_motion *d, int i) {
  return d->bridge.nodes + (size_t)i * KM_SAVED_PER_COLUMN * (size_t)km_driver_motion_substructure(d)->columns;
}

static double *node_tangent(const km_driver_motion *d, int i) {
  return d->bridge.tangents + (size_t)i * (size_t)km_driver_motion_substructure(d)->columns;
}

/* Converts the angular velocity w in `rate` to the rate of a ball's rotation vector v, with exp(v) from a
 * configuration to the present one: v' = w - v x w / 2 + v x (v x w) / 12 + O(v^4), the inverse of the exponential
 * map's derivative. */
static void rotation_vector_rate(const double *v, double *rate) {
  km_vec3 rotation = km_vec3_from_array(v), w = km_vec3_from_array(rate), v_cross_w = km_vec3_cross(rotation, w);
  w = km_vec3_axpy(-0.5, v_cross_w, w);
  w = km_vec3_axpy(1.0 / 12.0, km_vec3_cross(rotation, v_cross_w), w);
  rate[0] = w.x;
  rate[1] = w.y;
  rate[2] = w.z;
}

/* Computes sum_i of the weights times q_i - q and h t_i, q the saved configuration `base`. The state is overwritten. */
static void combine_nodes(km_driver_motion *d, const hermite_weights *w, const double *base, double *sum) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  const km_mechanism *m = d->c.mechanism;
  double *move = d->c.work, *rate = d->c.next_t;
  memset(sum, 0, (size_t)sub->columns * sizeof *sum);
  for (int i = 0; i < KM_BRIDGE_NODES; ++i) {
    km_state_restore(d->c.state, sub, node_configuration(d, i));
    km_state_difference(d->c.state, sub, base, move);
    memcpy(rate, node_tangent(d, i), (size_t)sub->columns * sizeof *rate);
    for (int k = 0; k < sub->columns; ++k) {
      int c = m->column_coordinate[sub->column_start + k], ball = m->ball_of[c];
      if (ball >= 0 && m->ball_coordinate[ball] == c)
        rotation_vector_rate(move + k, rate + k);
      sum[k] += w->value[i] * move[k] + w->tangent[i] * d->bridge.h * rate[k];
    }
  }
}

/* Returns the largest distance of closed configurations from the interpolant: h^5, valid for |q^(7)| / 7! <= 1 / h^2;
 * the Newton step not applied (km_step_tolerance, 1e-9); and the closure error (km_residual_tolerance) over the
 * smallest pivot, times the largest weight, below 100. */
static double allowed_deviation(const km_driver_motion *d) {
  static const double rounding = 1e-9;
  const double h = d->bridge.h;
  return fabs(h * h * h * h * h) + rounding + 100.0 * km_residual_tolerance / d->bridge.smallest_pivot;
}

/* True if the nodes lie on one smooth curve. */
static bool nodes_are_smooth(km_driver_motion *d) {
  double largest = 0.0;
  hermite_weights w;
  compute_highest_coefficient_weights(&w);
  combine_nodes(d, &w, node_configuration(d, 0), d->c.move);
  for (int k = 0; k < km_driver_motion_substructure(d)->columns; ++k)
    largest = km_larger_or_nan(fabs(d->c.move[k]), largest);
  return largest <= allowed_deviation(d);
}

/* Closes the loops with the driver fixed by the rows whose pivots stay away from 0 on the stretch. */
static bool close_independent_rows(km_driver_motion *d, double *correction) {
  static const double independent = 1e-5; /* relative pivot: those at the ends of the stretch are larger */
  km_partition *p = &d->c.state->partition[d->c.substructure];
  const double snapshot = p->min_relative_pivot;
  km_closure evidence;
  int worst;
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  p->min_relative_pivot = km_larger(independent, snapshot);
  km_close_with_driver(d->c.mechanism, d->c.state, d->c.substructure, d->c.column, &evidence);
  p->min_relative_pivot = snapshot;
  *correction = evidence.correction;
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  km_loops_update(d->c.mechanism, d->c.state, km_driver_motion_substructure(d));
  return km_loops_residual(d->c.mechanism, d->c.state, km_driver_motion_substructure(d), &worst) <=
         km_larger(km_driver_motion_closed_residual, d->c.mechanism->closure_tolerance);
}

/* Puts the drive at s; *correction is how far the closed configuration is from the interpolated one. */
static bool move_onto_bridge(km_driver_motion *d, double s, double *correction) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  const double u = (s - d->bridge.c) / d->bridge.h;
  hermite_weights value, derivative;
  compute_hermite_weights(u, &value, &derivative);
  km_state_save(d->c.state, sub, d->from_bridge);
  combine_nodes(d, &value, node_configuration(d, 0), d->c.move);
  km_state_restore(d->c.state, sub, node_configuration(d, 0));
  km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
  km_continuation_set_driver(&d->c, s);
  if (!close_independent_rows(d, correction)) {
    km_state_restore(d->c.state, sub, d->from_bridge);
    km_loops_update(d->c.mechanism, d->c.state, sub);
    return false;
  }
  km_state_save(d->c.state, sub, d->work_configuration);
  combine_nodes(d, &derivative, d->work_configuration, d->c.history.t);
  for (int k = 0; k < sub->columns; ++k)
    d->c.history.t[k] /= d->bridge.h;
  d->c.history.t[d->c.column] = 1.0;
  km_state_restore(d->c.state, sub, d->work_configuration);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  km_step_history_begin(&d->c.history, sub->columns);
  d->current.s = s;
  d->current.known = true;
  d->current.bridge = d->bridge.number;
  return true;
}

bool km_singular_bridge_place(km_driver_motion *d, double s) {
  double correction;
  return move_onto_bridge(d, s, &correction);
}

bool km_singular_bridge_is_active(const km_driver_motion *d, double s) {
  const km_singular_bridge *b = &d->bridge;
  return d->current.bridge > 0 && d->current.bridge == b->number &&
         fabs(s - b->c) < node_x[KM_BRIDGE_NODES - 1] * fabs(b->h);
}

bool km_singular_bridge_leave(km_driver_motion *d, double target) {
  const int end = (target > d->current.s) == (d->bridge.h > 0.0) ? KM_BRIDGE_NODES - 1 : 0;
  km_state_restore(d->c.state, km_driver_motion_substructure(d), node_configuration(d, end));
  d->current.s = d->bridge.c + node_x[end] * d->bridge.h;
  d->current.bridge = 0;
  return km_driver_motion_start(d);
}

/* Advances to s by controlled steps of at most `most`. */
static bool advance_in_steps(km_driver_motion *d, double s, double most) {
  enum { MOST_ATTEMPTS = 100 };
  static const double shortest_step = 1e-9;
  int limit = -1;
  double step = most;
  for (int i = 0; i < MOST_ATTEMPTS && step > shortest_step && d->current.s != s; ++i) {
    double left = s - d->current.s,
           h = fabs(left) <= step * km_driver_motion_reach_factor ? left : copysign(step, left);
    bool is_accepted = km_driver_motion_advance(d, h, km_driver_motion_correction_ratio, &limit) == KM_ATTEMPT_ACCEPTED;
    if (is_accepted && h == left) {
      d->current.s = s;
      km_continuation_set_driver(&d->c, s);
    }
    step = is_accepted ? km_smaller(2.0 * step, most) : 0.5 * fabs(h);
  }
  return d->current.s == s;
}

/* Finds the four nodes around c, starting at a regular configuration before it. The second step of the middle pair
 * crosses the singular configuration. */
static bool find_nodes(km_driver_motion *d, double c, double h) {
  int limit = -1;
  d->bridge.c = c;
  d->bridge.h = h;
  d->bridge.smallest_pivot = 1.0;
  for (int i = 0; i < KM_BRIDGE_NODES; ++i) {
    double s = c + node_x[i] * h;
    d->crosses_singular = 2 * i == KM_BRIDGE_NODES;
    bool is_reached = d->crosses_singular
                          ? km_driver_motion_advance(d, s - d->current.s, km_driver_motion_crossing_correction_ratio,
                                                     &limit) == KM_ATTEMPT_ACCEPTED
                          : advance_in_steps(d, s, fabs(h));
    d->crosses_singular = false;
    if (!is_reached)
      return false;
    d->current.s = s;
    km_continuation_set_driver(&d->c, s);
    km_state_save(d->c.state, km_driver_motion_substructure(d), node_configuration(d, i));
    memcpy(node_tangent(d, i), d->c.history.t,
           (size_t)km_driver_motion_substructure(d)->columns * sizeof *d->c.history.t);
    const km_partition *p = &d->c.state->partition[d->c.substructure];
    d->bridge.smallest_pivot = km_smaller(d->bridge.smallest_pivot, p->last_pivot / p->scale);
  }
  return true;
}

/* True at a turning point (dead point) of the driver: the rates of other coordinates exceed 1e3 (radians or sizes per
 * unit of the driver) at the distance to which an end is located. Bounded rates mean a singular configuration that is
 * not an end. */
static bool is_turning_point(const km_driver_motion *d) {
  static const double unbounded_rate = 1e3;
  double fastest = 0.0;
  for (int k = 0; k < km_driver_motion_substructure(d)->columns; ++k)
    fastest = km_larger_or_nan(fabs(d->c.history.t[k]), fastest);
  return !(fastest < unbounded_rate);
}

void km_singular_bridge_record(km_driver_motion *d, double h) {
  static const double shortest_recorded = 5e-3;
  if (fabs(h) < shortest_recorded)
    return;
  km_state_save(d->c.state, km_driver_motion_substructure(d), d->regular.pose);
  d->regular.s = d->current.s;
}

/* Returns to a configuration before the singular one: the recorded one, else the present one. */
static bool return_to_regular(km_driver_motion *d) {
  bool is_recorded = isfinite(d->regular.s);
  km_state_restore(d->c.state, km_driver_motion_substructure(d), is_recorded ? d->regular.pose : d->before_bridge.pose);
  d->current.s = is_recorded ? d->regular.s : d->before_bridge.position.s;
  return km_driver_motion_start(d);
}

/* True if the loops close within allowed_deviation of the interpolant at seven places of |u| < 1. In a narrow gap
 * between two dead points, and on another branch, they do not. */
static bool closes_near_interpolant(km_driver_motion *d) {
  enum { PARTS = 8 };
  double correction;
  for (int i = 1; i < PARTS; ++i)
    if (!move_onto_bridge(d, d->bridge.c + (2.0 * i / PARTS - 1.0) * d->bridge.h, &correction) ||
        !(correction <= allowed_deviation(d)))
      return false;
  return true;
}

/* True if closes_near_interpolant would detect a step onto a branch with the same tangent. Two such branches, k apart
 * in curvature, have pivots of k h at the nodes, and the interpolant between them misses the motion by up to k h^2 /
 * 80. Branches that touch to a higher order lie closer; only the longest stretch distinguishes them, if any. */
static bool is_decisive(const km_driver_motion *d) {
  return allowed_deviation(d) < d->bridge.smallest_pivot * fabs(d->bridge.h) / 80.0;
}

bool km_singular_bridge_build(km_driver_motion *d, double s, double side, double lead) {
  static const double shortest = 1e-3, longest = 0.13, growth = 2.0;
  const bool ignore_limits = d->c.ignore_limits;
  const int crossings = d->current.crossings;
  bool built = false;
  if (is_turning_point(d))
    return false;
  d->bridge.number = 0;
  km_driver_motion_store(d, &d->before_bridge);
  d->c.ignore_limits = true;
  for (int pass = 0; pass < 2 && !built; ++pass)
    for (double h = shortest; h < longest && !built; h *= growth)
      built = return_to_regular(d) && find_nodes(d, s + lead * side * h, side * h) && (pass > 0 || is_decisive(d)) &&
              nodes_are_smooth(d) && closes_near_interpolant(d);
  d->c.ignore_limits = ignore_limits;
  km_driver_motion_restore_snapshot(d, &d->before_bridge);
  if (built) {
    d->bridge.number = ++d->bridge.count;
    d->current.bridge = d->bridge.number;
    d->current.crossings = crossings + 1;
  }
  return built;
}
