/* Hermite bridges over singular configurations that a driven motion crosses smoothly (theory 4.11).
 *
 * Near a rank drop the pivots are too small to determine the tangent, over a stretch of the driver s that is wide
 * where branches touch. A smooth motion has regular configurations on both sides of that stretch. The curve through
 * four of them (node_curve.h) gives it on the stretch. The loops are then closed there by the rows that stay
 * independent, s fixed. Two tests show that both sides belong to one smooth motion: the coefficient of u^7 is of order
 * h^7, and closing the loops at seven places of |u| < 1 moves them by less than rounding does. A branch with another
 * tangent fails the second test by a part of h, one with the same tangent by a part of h^2. */
#include "base/number/tolerances.h"
#include "base/number/vectors.h"
#include "continuation/driver_step.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

#include <string.h>

/* Returns the largest distance of closed configurations from the interpolant: h^5, valid for |q^(7)| / 7! <= 1 / h^2;
 * the Newton step not applied (km_relative_zero, 1e-9); and the closure error (km_solved_rounding) over the
 * smallest pivot, times the largest weight, below 100. */
static double allowed_deviation(const km_driver_motion *d) {
  const double h = d->bridge.curve.h;
  return fabs(h * h * h * h * h) + km_relative_zero + 100.0 * km_solved_rounding / d->bridge.smallest_pivot;
}

/* Closes the loops with the driver fixed by the rows whose pivots stay away from 0 on the stretch. */
static bool close_independent_rows(km_driver_motion *d, double *correction) {
  const km_pivoting pivoting = {.driver = d->c.column,
                                .driver_never_pivot = true,
                                .min_relative_pivot = km_significant_ratio * km_singular_pivot};
  km_closure evidence;
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  km_loops_close_by(d->c.mechanism, d->c.state, d->c.substructure, &pivoting, &evidence);
  *correction = evidence.correction;
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  km_loops_update(d->c.mechanism, d->c.state, km_driver_motion_substructure(d));
  return km_loops_residual(d->c.mechanism, d->c.state, km_driver_motion_substructure(d)) <=
         km_larger(km_solved_rounding, d->c.mechanism->closure_tolerance);
}

/* Puts the drive at s; *correction is how far the closed configuration is from the interpolated one. */
static bool move_onto_bridge(km_driver_motion *d, double s, double *correction) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  km_state_save(d->c.state, sub, d->from_bridge);
  km_node_curve_place(&d->bridge.curve, &d->c, s);
  km_continuation_set_driver(&d->c, s);
  if (!close_independent_rows(d, correction)) {
    km_state_restore(d->c.state, sub, d->from_bridge);
    km_loops_update(d->c.mechanism, d->c.state, sub);
    return false;
  }
  km_node_curve_tangent(&d->bridge.curve, &d->c, s, d->c.history.t);
  d->c.history.t[d->c.column] = 1.0;
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
         fabs(s - b->curve.c) < km_node_place[KM_CURVE_NODES - 1] * fabs(b->curve.h);
}

bool km_singular_bridge_leave(km_driver_motion *d, double target) {
  const int end = (target > d->current.s) == (d->bridge.curve.h > 0.0) ? KM_CURVE_NODES - 1 : 0;
  km_state_restore(d->c.state, km_driver_motion_substructure(d), d->bridge.curve.configuration[end]);
  d->current.s = d->bridge.curve.c + km_node_place[end] * d->bridge.curve.h;
  d->current.bridge = 0;
  return km_driver_motion_start(d);
}

/* Advances to s by controlled steps of at most `most`. */
static bool advance_in_steps(km_driver_motion *d, double s, double most) {
  enum { MOST_ATTEMPTS = 100 };
  int limit = -1;
  double step = most;
  for (int i = 0; i < MOST_ATTEMPTS && step > km_relative_zero && d->current.s != s; ++i) {
    double doubled = 2.0 * step;
    if (km_driver_motion_step_towards(d, s, &step, &limit) == KM_ATTEMPT_ACCEPTED)
      step = km_smaller(doubled, most);
  }
  return d->current.s == s;
}

/* Finds the four nodes around c, starting at a regular configuration before it. The second step of the middle pair
 * crosses the singular configuration. */
static bool find_nodes(km_driver_motion *d, double c, double h) {
  int limit = -1;
  d->bridge.curve.c = c;
  d->bridge.curve.h = h;
  d->bridge.smallest_pivot = 1.0;
  for (int i = 0; i < KM_CURVE_NODES; ++i) {
    double s = c + km_node_place[i] * h;
    d->crosses_singular = 2 * i == KM_CURVE_NODES;
    bool is_reached = d->crosses_singular ? km_driver_motion_advance(d, s - d->current.s, km_strict_correction_ratio,
                                                                     &limit) == KM_ATTEMPT_ACCEPTED
                                          : advance_in_steps(d, s, fabs(h));
    d->crosses_singular = false;
    if (!is_reached)
      return false;
    d->current.s = s;
    km_continuation_set_driver(&d->c, s);
    km_node_curve_record(&d->bridge.curve, &d->c, i, d->c.history.t);
    const km_factor_evidence e = km_factor_get_evidence(d->c.state->factor[d->c.substructure]);
    d->bridge.smallest_pivot = km_smaller(d->bridge.smallest_pivot, e.last_pivot / e.scale);
  }
  return true;
}

/* True at a turning point (dead point) of the driver: the rates of other coordinates exceed 1e3 (radians or sizes per
 * unit of the driver) at the distance to which an end is located. Bounded rates mean a singular configuration that is
 * not an end. */
static bool is_turning_point(const km_driver_motion *d) {
  return !(km_max_norm(d->c.history.t, km_driver_motion_substructure(d)->columns) < km_driver_motion_diverging);
}

void km_singular_bridge_record(km_driver_motion *d, double h) {
  if (fabs(h) < KM_SINGULAR_BRACKET)
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
    if (!move_onto_bridge(d, d->bridge.curve.c + (2.0 * i / PARTS - 1.0) * d->bridge.curve.h, &correction) ||
        !(correction <= allowed_deviation(d)))
      return false;
  return true;
}

/* True if closes_near_interpolant would detect a step onto a branch with the same tangent. Two such branches, k apart
 * in curvature, have pivots of k h at the nodes, and the interpolant between them misses the motion by up to k h^2 /
 * 80. Branches that touch to a higher order lie closer; only the longest stretch distinguishes them, if any. */
static bool is_decisive(const km_driver_motion *d) {
  return allowed_deviation(d) < d->bridge.smallest_pivot * fabs(d->bridge.curve.h) / 80.0;
}

bool km_singular_bridge_build(km_driver_motion *d, double s, double side, double lead) {
  const bool ignore_limits = d->c.ignore_limits;
  const int crossings = d->current.crossings;
  bool built = false;
  if (is_turning_point(d))
    return false;
  d->bridge.number = 0;
  km_driver_motion_store(d, &d->before_bridge);
  d->c.ignore_limits = true;
  for (int pass = 0; pass < 2 && !built; ++pass)
    for (double h = km_singular_step; 2.0 * h < km_longest_step && !built; h *= 2.0)
      built = return_to_regular(d) && find_nodes(d, s + lead * side * h, side * h) && (pass > 0 || is_decisive(d)) &&
              km_node_curve_highest_coefficient(&d->bridge.curve, &d->c) <= allowed_deviation(d) &&
              closes_near_interpolant(d);
  d->c.ignore_limits = ignore_limits;
  km_driver_motion_restore_snapshot(d, &d->before_bridge);
  if (built) {
    d->bridge.number = ++d->bridge.count;
    d->current.bridge = d->bridge.number;
    d->current.crossings = crossings + 1;
  }
  return built;
}
