/* One step of a driven continuation: predictor, corrector, acceptance (theory 4.6, 4.7).
 *
 *   one freedom      : cubic or degree-10 predictor; the loops determine the result
 *   several freedoms : path of least motion dq/ds = t(q), Adams-Bashforth, Runge-Kutta or backward difference
 *   accepted if      : |D correction| <= ratio |D move| + 1e-9, cos(t, t_new) large, rank not lower,
 *                      sign of det(pivot block) unchanged or |h| <= 1e-5, no limit exceeded */
#include "continuation/driver_step.h"

#include "base/number/vectors.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

bool km_driver_motion_start(km_driver_motion *d) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  double residual = km_loops_residual(d->c.mechanism, d->c.state, sub);
  km_search_pivots_by(d->c.mechanism, d->c.state, d->c.substructure,
                      &(km_pivoting){.driver = d->c.column, .basis = KM_BASIS_ANY},
                      km_rank_tolerance(d->c.mechanism, sub, residual));
  km_constant_rank_begin(&d->c.constant_rank, d->c.mechanism, d->c.state, d->c.substructure, d->c.column, &d->arena);
  d->current.known = km_continuation_tangent(&d->c, NULL, d->c.history.t);
  km_step_history_set_reference(&d->c.history, d->c.state->factor[d->c.substructure]);
  km_step_history_begin(&d->c.history, km_driver_motion_substructure(d)->columns);
  return d->current.known;
}

/* True if det(pivot block) changes its sign over the step. It does so, with one freedom, only at a configuration that
 * is singular for the driver; a change over a long step indicates a jump to another branch. */
static bool sign_changed(km_driver_motion *d) {
  const km_factor *p = d->c.state->factor[d->c.substructure];
  km_factor *reference = d->c.history.reference;
  if (!km_continuation_has_single_freedom(&d->c, km_factor_freedom(p)) ||
      km_factor_rank(p) != km_factor_rank(reference))
    return false;
  if (km_factor_search_count(p) != km_factor_search_count(reference)) {
    km_factor_refactor(reference, km_state_jacobian(d->c.state, km_driver_motion_substructure(d)), KM_BASIS_ANY);
    p = reference;
  }
  return km_factor_sign(p) != d->c.history.sign;
}

static bool has_single_freedom(const km_driver_motion *d) {
  return km_continuation_has_single_freedom(&d->c, km_factor_freedom(d->c.history.reference));
}

/* Rejections in a row before the implicit predictor is tried. */
enum { MOST_EXPLICIT_REJECTIONS = 2 };

/* Allocates the closest-configuration solver; false with ball joints or without memory. */
static bool reserve_closest(km_driver_motion *d) {
  if (d->closest || d->c.mechanism->ball_count > 0)
    return d->closest != NULL;
  km_nearest_configuration *closest = KM_ARENA_NEW(&d->arena, km_nearest_configuration, 1);
  if (closest && km_nearest_configuration_reserve(closest, d->c.mechanism, km_driver_motion_substructure(d), &d->arena))
    d->closest = closest;
  return d->closest != NULL;
}

/* Predicts by the second-order backward difference, as a closest configuration; false if its error is too large. The
 * state and its pivots return to the start of the step. */
static bool predict_implicit(km_driver_motion *d, double h) {
  if (fabs(h) < km_driver_motion_short_step || !reserve_closest(d))
    return false;
  d->error_ratio = km_minimum_norm_path_predict_implicit(d->closest, d->c.mechanism, d->c.state, d->c.substructure,
                                                         d->c.column, &d->c.history, h, d->c.move);
  km_state_restore(d->c.state, km_driver_motion_substructure(d), d->c.from);
  km_factor_copy_pivots(d->c.state->factor[d->c.substructure], d->c.history.reference);
  d->c.state->pivot_driver[d->c.substructure] = d->c.column;
  return d->implicit = d->error_ratio <= 1.0;
}

/* Predicts along the path of least motion: multistep, then Runge-Kutta, then implicit, in the order of cost. The
 * implicit predictor comes first on a stiff path. False if h is too long. */
static bool predict_minimum_norm_path(km_driver_motion *d, double h) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  if (d->current.is_stiff && (predict_implicit(d, h) || d->rejections == 0))
    return d->implicit;
  d->error_ratio = km_minimum_norm_path_predict_multistep(d->c.mechanism, sub, &d->c.history, h, d->c.move);
  if (!(d->error_ratio <= 1.0)) {
    d->error_ratio =
        km_minimum_norm_path_predict_runge_kutta(&d->path, d->c.mechanism, d->c.state, d->c.substructure, d->c.column,
                                                 d->c.history.reference, d->c.from, d->c.history.t, h, d->c.move);
    km_state_restore(d->c.state, sub, d->c.from);
  }
  return d->error_ratio <= 1.0 ||
         (!d->current.is_stiff && d->rejections >= MOST_EXPLICIT_REJECTIONS && predict_implicit(d, h));
}

double km_driver_step_slide_position(const km_driver_motion *d, int column) {
  const km_mechanism *m = d->c.mechanism;
  int c = m->column_coordinate[km_driver_motion_substructure(d)->column_start + column];
  return km_model_coordinate_is_length(m->model, c) ? d->c.state->q[c] / m->unit[c] : 0.0;
}

/* Returns the coordinate of a slide that diverges: distance and rate above 1e3 and growing; -1: none. */
static int find_diverging_slide(const km_driver_motion *d, double h) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  double fastest = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    fastest = km_larger(fabs(d->c.next_t[k]), fastest);
  for (int k = 0; k < sub->columns && fastest > km_driver_motion_diverging; ++k)
    if (fabs(d->c.next_t[k]) > km_driver_motion_diverging &&
        d->c.next_t[k] * h * km_driver_step_slide_position(d, k) > 0.0 &&
        fabs(km_driver_step_slide_position(d, k)) > km_driver_motion_diverging)
      return d->c.mechanism->column_coordinate[sub->column_start + k];
  return -1;
}

/* Predicts `move` for a step h. The corrector determines the result with one freedom; the prediction determines the
 * motion with several. False if h is too long. */
static bool predict(km_driver_motion *d, double h) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  bool is_within_error = true;
  d->implicit = false;
  d->error_ratio = 0.0;
  if (has_single_freedom(d) || d->c.constant_rank.is_active)
    km_continuation_predict(&d->c, h, has_single_freedom(d));
  else
    is_within_error = predict_minimum_norm_path(d, h);
  for (int k = 0; k < sub->columns; ++k)
    /* A distant slide moves relative to its distance, so that each tenfold takes as many steps. */
    if (!(fabs(d->c.move[k]) <= km_max_newton_step) &&
        !(fabs(d->c.move[k]) <= km_max_newton_step * fabs(km_driver_step_slide_position(d, k))))
      return false;
  return is_within_error;
}

/* True if the start can be singular: with several freedoms a rank-deficient start leaves the tangent undetermined. */
static bool may_be_singular(const km_driver_motion *d) {
  return !d->c.constant_rank.is_active && !has_single_freedom(d) && d->c.history.last_h == 0.0 &&
         km_factor_rank(d->c.history.reference) < km_driver_motion_substructure(d)->rows;
}

/* True if the predicted configuration violates the closure by over 100 times the predictor's error. */
static bool violates_closure(km_driver_motion *d) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  double longest = km_max_norm(d->c.move, sub->columns);
  km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  double misfit = km_loops_residual(d->c.mechanism, d->c.state, sub);
  km_state_restore(d->c.state, sub, d->c.from);
  return misfit >
         km_significant_ratio * (km_path_allowed * longest + km_path_rounding) + d->c.mechanism->closure_tolerance;
}

/* True if the rank at the trial configuration differs from that of the start: the start was singular. */
static bool rank_changed(km_driver_motion *d) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  km_factor *p = d->c.state->factor[d->c.substructure];
  km_search_pivots_by(d->c.mechanism, d->c.state, d->c.substructure,
                      &(km_pivoting){.driver = d->c.column, .basis = KM_BASIS_ANY},
                      km_rank_tolerance(d->c.mechanism, sub, 0.0));
  int rank = km_factor_rank(p);
  km_factor_copy_pivots(p, d->c.history.reference);
  km_factor_refactor(p, km_state_jacobian(d->c.state, sub), KM_BASIS_ANY);
  return rank != km_factor_rank(d->c.history.reference);
}

/* Predicts and corrects a step to s + h; the state stays at the trial configuration. */
static km_attempt try_step(km_driver_motion *d, double h, double correction_ratio) {
  /* the step is too short to show whether the start is singular */
  if (d->rejections > 0 && fabs(h) < km_driver_motion_short_step && may_be_singular(d))
    return KM_ATTEMPT_TOO_LONG;
  if (!predict(d, h) || (may_be_singular(d) && !d->implicit && violates_closure(d)))
    return KM_ATTEMPT_TOO_LONG;
  km_step_terms terms =
      km_step_terms_of(correction_ratio, km_step_length(d->c.mechanism, km_driver_motion_substructure(d), d->c.move));
  terms.parameter = d->current.s + h;
  terms.least_rank = km_factor_rank(d->c.history.reference);
  terms.leaves_end = d->current.stopped * h < 0.0;
  km_step_outcome outcome = km_continuation_correct(&d->c, &terms);
  if (outcome != KM_STEP_ACCEPTED)
    return outcome == KM_STEP_OPEN ? KM_ATTEMPT_OPEN : KM_ATTEMPT_TOO_LONG;
  if (may_be_singular(d) && rank_changed(d))
    return KM_ATTEMPT_TOO_LONG;
  bool changed = !d->crosses_singular && sign_changed(d);
  if (changed && fabs(h) > km_driver_motion_short_step)
    return KM_ATTEMPT_TOO_LONG;
  d->current.crossings += changed;
  return KM_ATTEMPT_ACCEPTED;
}

/* Tests the trial configuration against limits and divergence; *limit: the coordinate that is rejected. */
static km_attempt check_limits(const km_driver_motion *d, double h, int *limit) {
  int passed = km_continuation_limit(&d->c, h), diverging = passed < 0 ? find_diverging_slide(d, h) : -1;
  *limit = passed >= 0 ? passed : diverging >= 0 ? diverging : *limit;
  return passed >= 0 ? KM_ATTEMPT_AT_LIMIT : diverging >= 0 ? KM_ATTEMPT_DIVERGING : KM_ATTEMPT_ACCEPTED;
}

km_attempt km_driver_motion_advance(km_driver_motion *d, double h, double correction_ratio, int *limit) {
  km_state_save(d->c.state, km_driver_motion_substructure(d), d->c.from);
  km_attempt result = try_step(d, h, correction_ratio);
  result = result == KM_ATTEMPT_ACCEPTED ? check_limits(d, h, limit) : result;
  if (result != KM_ATTEMPT_ACCEPTED) {
    ++d->rejections;
    km_continuation_reject(&d->c);
    return result;
  }
  d->rejections = 0;
  d->current.is_stiff = d->implicit;
  km_continuation_accept(&d->c, h);
  d->current.s += h;
  d->current.known = true;
  return KM_ATTEMPT_ACCEPTED;
}

/* True if several freedoms remain on a constant-rank motion: its predictor is second-order Adams-Bashforth alone. */
static bool has_several_constant_rank_tangents(const km_driver_motion *d) {
  return d->c.constant_rank.is_active && d->c.constant_rank.count > 1;
}

double km_driver_motion_longest_step(const km_driver_motion *d) {
  static const double with_several_freedoms = 0.01;
  return has_several_constant_rank_tangents(d) ? with_several_freedoms : km_longest_step;
}

/* Returns the next step size after an accepted step of h: doubled if the predictor's error ratio permits it. Also
 * clears the mark of a turning point that the step left. */
static double lengthen_step(km_driver_motion *d, double step, double h) {
  if (fabs(h) > km_root_rounding && !km_continuation_is_singular(d->c.state->factor[d->c.substructure]))
    d->current.stopped = 0.0;
  double share = step / fabs(h), square = share * share;
  double doubled = d->current.is_stiff ? 4.0 * square : 16.0 * (square * square);
  bool may_grow = d->error_ratio * doubled < km_driver_motion_growth_limit;
  return may_grow ? km_smaller(2.0 * step, km_driver_motion_longest_step(d)) : step;
}

km_attempt km_driver_motion_step_towards(km_driver_motion *d, double target, double *step, int *limit) {
  double remaining = target - d->current.s;
  bool arrives = km_driver_motion_reaches(remaining, *step);
  /* two equal steps instead of a short last one, of which the multistep predictor could use little */
  bool splits =
      (d->current.is_stiff || has_several_constant_rank_tangents(d)) && !arrives && fabs(remaining) < 2.0 * *step;
  double h = arrives ? remaining : splits ? 0.5 * remaining : copysign(*step, remaining);
  km_attempt result = km_driver_motion_advance(d, h, km_correction_ratio, limit);
  *step = result == KM_ATTEMPT_ACCEPTED ? lengthen_step(d, *step, h) : 0.5 * fabs(h);
  if (result == KM_ATTEMPT_ACCEPTED && arrives) { /* s + (target - s) can differ from target by one rounding */
    d->current.s = target;
    km_continuation_set_driver(&d->c, target);
  }
  return result;
}
