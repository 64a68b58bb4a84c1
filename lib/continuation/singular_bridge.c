/* Bridges over singular configurations that a drive passes smoothly.
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

static const double place_of[KM_BRIDGE_NODES] = {-2.0, -1.0, 1.0, 2.0}; /* x_i */

/* Weights of the nodes' configurations and of their tangents times h. */
typedef struct weights {
  double value[KM_BRIDGE_NODES], tangent[KM_BRIDGE_NODES];
} weights;

/* l_i(u), its derivative, and l_i'(x_i). */
static void lagrange(int i, double u, double *l, double *slope, double *own_slope) {
  *l = 1.0;
  *slope = *own_slope = 0.0;
  for (int j = 0; j < KM_BRIDGE_NODES; ++j)
    if (j != i) {
      double width = place_of[i] - place_of[j], factor = (u - place_of[j]) / width;
      *slope = *slope * factor + *l / width;
      *l *= factor;
      *own_slope += 1.0 / width;
    }
}

/* Computes the weights of q and of dq/du at u. */
static void weigh(double u, weights *value, weights *derivative) {
  for (int i = 0; i < KM_BRIDGE_NODES; ++i) {
    double l, slope, own_slope, way = u - place_of[i];
    lagrange(i, u, &l, &slope, &own_slope);
    value->value[i] = (1.0 - 2.0 * own_slope * way) * l * l;
    value->tangent[i] = way * l * l;
    derivative->value[i] = -2.0 * own_slope * l * l + 2.0 * (1.0 - 2.0 * own_slope * way) * l * slope;
    derivative->tangent[i] = l * l + 2.0 * way * l * slope;
  }
}

/* Computes the weights that give the coefficient of u^7. */
static void weigh_highest(weights *w) {
  for (int i = 0; i < KM_BRIDGE_NODES; ++i) {
    double leading = 1.0, own_slope = 0.0;
    for (int j = 0; j < KM_BRIDGE_NODES; ++j)
      if (j != i) {
        leading /= place_of[i] - place_of[j];
        own_slope += 1.0 / (place_of[i] - place_of[j]);
      }
    w->value[i] = -2.0 * own_slope * leading * leading;
    w->tangent[i] = leading * leading;
  }
}

static double *node(const km_driver_motion *d, int i) {
  return d->bridge.nodes + (size_t)i * KM_SAVED_PER_COLUMN * (size_t)km_driver_motion_substructure(d)->columns;
}

static double *tangent(const km_driver_motion *d, int i) {
  return d->bridge.tangents + (size_t)i * (size_t)km_driver_motion_substructure(d)->columns;
}

/* The rate of a ball's rotation vector v, with exp(v) from a configuration to the present one, from the angular
 * velocity w there: v' = w - v x w / 2 + v x (v x w) / 12 + O(v^4), the inverse of the exponential map's derivative. */
static void rotation_vector_rate(const double *v, double *rate) {
  km_vec3 turn = km_vec3_make(v), w = km_vec3_make(rate), once = km_vec3_cross(turn, w);
  w = km_vec3_axpy(-0.5, once, w);
  w = km_vec3_axpy(1.0 / 12.0, km_vec3_cross(turn, once), w);
  rate[0] = w.x;
  rate[1] = w.y;
  rate[2] = w.z;
}

/* Computes sum_i of the weights times q_i - q and h t_i, q the saved configuration `base`. The state is overwritten. */
static void combine(km_driver_motion *d, const weights *w, const double *base, double *sum) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  const km_mechanism *m = d->c.mechanism;
  double *move = d->c.work, *rate = d->c.next_t;
  memset(sum, 0, (size_t)sub->columns * sizeof *sum);
  for (int i = 0; i < KM_BRIDGE_NODES; ++i) {
    km_state_restore(d->c.state, sub, node(d, i));
    km_state_difference(d->c.state, sub, base, move);
    memcpy(rate, tangent(d, i), (size_t)sub->columns * sizeof *rate);
    for (int k = 0; k < sub->columns; ++k) {
      int c = m->column_coordinate[sub->column_start + k], ball = m->ball_of[c];
      if (ball >= 0 && m->ball_coordinate[ball] == c)
        rotation_vector_rate(move + k, rate + k);
      sum[k] += w->value[i] * move[k] + w->tangent[i] * d->bridge.h * rate[k];
    }
  }
}

/* How far closed configurations may lie from the interpolant: h^5, as long as |q^(7)| / 7! <= 1 / h^2; the steps that
 * closing leaves undone (km_step_tolerance, 1e-9); and the loops' error (km_residual_tolerance) over the smallest pivot, times the
 * largest weight, below 100. */
static double allowed(const km_driver_motion *d) {
  static const double rounding = 1e-9;
  const double h = d->bridge.h;
  return fabs(h * h * h * h * h) + rounding + 100.0 * km_residual_tolerance / d->bridge.smallest_pivot;
}

/* True if the nodes lie on one smooth curve. */
static bool is_smooth(km_driver_motion *d) {
  double largest = 0.0;
  weights w;
  weigh_highest(&w);
  combine(d, &w, node(d, 0), d->c.move);
  for (int k = 0; k < km_driver_motion_substructure(d)->columns; ++k)
    largest = km_larger_or_nan(fabs(d->c.move[k]), largest);
  return largest <= allowed(d);
}

/* Closes the loops with the driver fixed by the rows whose pivots stay away from 0 on the stretch. */
static bool close_independent(km_driver_motion *d, double *correction) {
  static const double independent = 1e-5; /* relative pivot: those at the ends of the stretch are larger */
  km_partition *p = &d->c.state->partition[d->c.substructure];
  const double kept = p->min_relative_pivot;
  km_closure evidence;
  int worst;
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  p->min_relative_pivot = km_larger(independent, kept);
  km_close_with_driver(d->c.mechanism, d->c.state, d->c.substructure, d->c.column, &evidence);
  p->min_relative_pivot = kept;
  *correction = evidence.correction;
  km_state_invalidate_pivots(d->c.state, d->c.substructure);
  km_loops_update(d->c.mechanism, d->c.state, km_driver_motion_substructure(d));
  return km_loops_residual(d->c.mechanism, d->c.state, km_driver_motion_substructure(d), &worst) <=
         km_larger(km_driver_motion_closed, d->c.mechanism->closure_tolerance);
}

/* Puts the drive at s; *correction is how far the closed configuration is from the interpolated one. */
static bool place(km_driver_motion *d, double s, double *correction) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  const double u = (s - d->bridge.c) / d->bridge.h;
  weights value, derivative;
  weigh(u, &value, &derivative);
  km_state_save(d->c.state, sub, d->from_bridge);
  combine(d, &value, node(d, 0), d->c.move);
  km_state_restore(d->c.state, sub, node(d, 0));
  km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
  km_continuation_place(&d->c, s);
  if (!close_independent(d, correction)) {
    km_state_restore(d->c.state, sub, d->from_bridge);
    km_loops_update(d->c.mechanism, d->c.state, sub);
    return false;
  }
  km_state_save(d->c.state, sub, d->near);
  combine(d, &derivative, d->near, d->c.course.t);
  for (int k = 0; k < sub->columns; ++k)
    d->c.course.t[k] /= d->bridge.h;
  d->c.course.t[d->c.column] = 1.0;
  km_state_restore(d->c.state, sub, d->near);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  km_step_history_begin(&d->c.course, sub->columns);
  d->here.s = s;
  d->here.known = true;
  d->here.bridge = d->bridge.number;
  return true;
}

bool km_singular_bridge_place(km_driver_motion *d, double s) {
  double correction;
  return place(d, s, &correction);
}

bool km_singular_bridge_is_active(const km_driver_motion *d, double s) {
  const km_singular_bridge *b = &d->bridge;
  return d->here.bridge > 0 && d->here.bridge == b->number &&
         fabs(s - b->c) < place_of[KM_BRIDGE_NODES - 1] * fabs(b->h);
}

bool km_singular_bridge_leave(km_driver_motion *d, double target) {
  const int end = (target > d->here.s) == (d->bridge.h > 0.0) ? KM_BRIDGE_NODES - 1 : 0;
  km_state_restore(d->c.state, km_driver_motion_substructure(d), node(d, end));
  d->here.s = d->bridge.c + place_of[end] * d->bridge.h;
  d->here.bridge = 0;
  return km_driver_motion_start(d);
}

/* Goes to s by controlled steps of at most `most`. */
static bool go(km_driver_motion *d, double s, double most) {
  enum { MOST_ATTEMPTS = 100 };
  static const double no_step = 1e-9;
  int limit = -1;
  double step = most;
  for (int i = 0; i < MOST_ATTEMPTS && step > no_step && d->here.s != s; ++i) {
    double left = s - d->here.s, h = fabs(left) <= step * km_driver_motion_reach ? left : copysign(step, left);
    bool taken = km_driver_motion_advance(d, h, km_driver_motion_tightness, &limit) == KM_ATTEMPT_ACCEPTED;
    if (taken && h == left) {
      d->here.s = s;
      km_continuation_place(&d->c, s);
    }
    step = taken ? km_smaller(2.0 * step, most) : 0.5 * fabs(h);
  }
  return d->here.s == s;
}

/* The nodes around c, from a regular configuration before it. */
static bool find_nodes(km_driver_motion *d, double c, double h) {
  int limit = -1;
  d->bridge.c = c;
  d->bridge.h = h;
  d->bridge.smallest_pivot = 1.0;
  for (int i = 0; i < KM_BRIDGE_NODES; ++i) {
    double s = c + place_of[i] * h;
    d->passing = 2 * i == KM_BRIDGE_NODES;
    bool there = d->passing ? km_driver_motion_advance(d, s - d->here.s, km_driver_motion_crossing_tightness, &limit) ==
                                  KM_ATTEMPT_ACCEPTED
                            : go(d, s, fabs(h));
    d->passing = false;
    if (!there)
      return false;
    d->here.s = s;
    km_continuation_place(&d->c, s);
    km_state_save(d->c.state, km_driver_motion_substructure(d), node(d, i));
    memcpy(tangent(d, i), d->c.course.t, (size_t)km_driver_motion_substructure(d)->columns * sizeof *d->c.course.t);
    const km_partition *p = &d->c.state->partition[d->c.substructure];
    d->bridge.smallest_pivot = km_smaller(d->bridge.smallest_pivot, p->last_pivot / p->scale);
  }
  return true;
}

/* At a toggle the rates of others grow without bound: by so much, in radians or sizes of the substructure for each of
 * the driver's, at the distance at which an end is located. Where they don't, the mechanism is singular, but not there
 * that it turns back. */
static bool is_toggle(const km_driver_motion *d) {
  static const double beyond_bounds = 1e3;
  double fastest = 0.0;
  for (int k = 0; k < km_driver_motion_substructure(d)->columns; ++k)
    fastest = km_larger_or_nan(fabs(d->c.course.t[k]), fastest);
  return !(fastest < beyond_bounds);
}

void km_singular_bridge_record(km_driver_motion *d, double h) {
  static const double long_enough = 5e-3;
  if (fabs(h) < long_enough)
    return;
  km_state_save(d->c.state, km_driver_motion_substructure(d), d->regular.pose);
  d->regular.s = d->here.s;
}

/* Back to a place before the singular configuration: the one that was remembered, else the present one. */
static bool return_to_regular(km_driver_motion *d) {
  bool is_remembered = isfinite(d->regular.s);
  km_state_restore(d->c.state, km_driver_motion_substructure(d),
                   is_remembered ? d->regular.pose : d->before_bridge.pose);
  d->here.s = is_remembered ? d->regular.s : d->before_bridge.place.s;
  return km_driver_motion_start(d);
}

/* True if the loops close within `allowed` of the interpolant at seven places of |u| < 1. In a narrow gap between two
 * dead points, and on another branch, they don't. */
static bool closes_within(km_driver_motion *d) {
  enum { PARTS = 8 };
  double correction;
  for (int i = 1; i < PARTS; ++i)
    if (!place(d, d->bridge.c + (2.0 * i / PARTS - 1.0) * d->bridge.h, &correction) || !(correction <= allowed(d)))
      return false;
  return true;
}

/* True if closes_within would notice a step onto a branch with the same tangent. Two such branches, k apart in
 * curvature, have pivots of k h at the nodes, and the interpolant between them misses the motion by up to k h^2 / 80.
 * Branches that touch to a higher order lie closer together than that: they are told apart by the longest stretch, or
 * not at all. */
static bool is_decisive(const km_driver_motion *d) {
  return allowed(d) < d->bridge.smallest_pivot * fabs(d->bridge.h) / 80.0;
}

bool km_singular_bridge_build(km_driver_motion *d, double s, double side, double lead) {
  static const double shortest = 1e-3, longest = 0.13, growth = 2.0;
  const bool ignore_limits = d->c.ignore_limits;
  const int crossings = d->here.crossings;
  bool built = false;
  if (is_toggle(d))
    return false;
  d->bridge.number = 0;
  km_driver_motion_store(d, &d->before_bridge);
  d->c.ignore_limits = true;
  for (int pass = 0; pass < 2 && !built; ++pass)
    for (double h = shortest; h < longest && !built; h *= growth)
      built = return_to_regular(d) && find_nodes(d, s + lead * side * h, side * h) && (pass > 0 || is_decisive(d)) &&
              is_smooth(d) && closes_within(d);
  d->c.ignore_limits = ignore_limits;
  km_driver_motion_recall(d, &d->before_bridge);
  if (built) {
    d->bridge.number = ++d->bridge.count;
    d->here.bridge = d->bridge.number;
    d->here.crossings = crossings + 1;
  }
  return built;
}
