/* A step of a drive: predicted, corrected, judged. */
#include "continuation/driver_step.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

static void remember_pivots(km_driver_motion *d) {
  km_partition_copy_pivots(&d->c.course.reference, &d->c.state->partition[d->c.substructure]);
}

/* Pivots and tangent of the present pose, searched. */
bool km_driver_motion_start(km_driver_motion *d) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  int worst;
  km_loops_update(d->c.mechanism, d->c.state, sub);
  double residual = km_loops_residual(d->c.mechanism, d->c.state, sub, &worst);
  km_search_pivots_for_steps(d->c.mechanism, d->c.state, d->c.substructure, d->c.column,
                             km_rank_tolerance(d->c.mechanism, sub, residual));
  km_constant_rank_begin(&d->c.steady, d->c.mechanism, d->c.state, d->c.substructure, d->c.column, &d->arena);
  d->here.known = km_continuation_tangent(&d->c, NULL, d->c.course.t);
  remember_pivots(d);
  km_step_history_begin(&d->c.course, km_driver_motion_substructure(d)->columns);
  return d->here.known;
}

/* Where the driver has the only freedom, det of the pivot block changes sign only at a singular pose of the
 * driver: a change over a step that should be regular is a jump to another branch. */
static bool sign_changed(km_driver_motion *d) {
  const km_partition *p = &d->c.state->partition[d->c.substructure];
  if (!km_continuation_has_single_freedom(&d->c, km_partition_freedom(p)) || p->rank != d->c.course.reference.rank)
    return false;
  if (p->search_count == d->c.course.reference.search_count)
    return p->sign != d->c.course.reference.sign;
  int before = d->c.course.reference.sign;
  km_partition_refactor_full_pattern(&d->c.course.reference,
                                     km_state_jacobian(d->c.state, km_driver_motion_substructure(d)));
  int after = d->c.course.reference.sign;
  d->c.course.reference.sign = before;
  return before != after;
}

static bool is_alone(const km_driver_motion *d) {
  return km_continuation_has_single_freedom(&d->c, km_partition_freedom(&d->c.course.reference));
}

/* So many refusals in a row show that the path may be stiff. */
enum { MOST_BENT = 2 };

/* False for ball joints, or out of memory. */
static bool need_closest(km_driver_motion *d) {
  if (d->closest || d->c.mechanism->ball_count > 0)
    return d->closest != NULL;
  km_nearest_configuration *closest = KM_ARENA_NEW(&d->arena, km_nearest_configuration, 1);
  if (closest && km_nearest_configuration_reserve(closest, d->c.mechanism, km_driver_motion_substructure(d), &d->arena))
    d->closest = closest;
  return d->closest != NULL;
}

static bool draw(km_driver_motion *d, double h) {
  if (fabs(h) < km_driver_motion_creeping || !need_closest(d))
    return false;
  d->strain = km_minimum_norm_path_record(d->closest, d->c.mechanism, d->c.state, d->c.substructure, d->c.column,
                                          &d->c.course, h, d->c.move);
  km_state_restore(d->c.state, km_driver_motion_substructure(d), d->c.from);
  km_partition_copy_pivots(&d->c.state->partition[d->c.substructure], &d->c.course.reference);
  d->c.state->pivot_driver[d->c.substructure] = d->c.column;
  return d->drawn = d->strain <= 1.0;
}

/* Along the path of least motion, by whichever way serves, those that cost least first. */
static bool follow_path(km_driver_motion *d, double h) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  if (d->here.stiff && (draw(d, h) || d->bent == 0))
    return d->drawn;
  d->strain = km_minimum_norm_path_continue(d->c.mechanism, sub, &d->c.course, h, d->c.move);
  if (!(d->strain <= 1.0)) {
    d->strain = km_minimum_norm_path_predict(&d->path, d->c.mechanism, d->c.state, d->c.substructure, d->c.column,
                                             &d->c.course.reference, d->c.from, d->c.course.t, h, d->c.move);
    km_state_restore(d->c.state, sub, d->c.from);
  }
  return d->strain <= 1.0 || (!d->here.stiff && d->bent >= MOST_BENT && draw(d, h));
}

/* Where a slide is, in substructure sizes; 0 of an angle. */
double km_driver_step_diverges(const km_driver_motion *d, int column) {
  const km_mechanism *m = d->c.mechanism;
  int c = m->column_coordinate[km_driver_motion_substructure(d)->column_start + column];
  return km_model_coordinate_is_length(m->model, c) ? d->c.state->q[c] / m->unit[c] : 0.0;
}

/* How far a column may go in one step. A slide that leaves takes as many steps to each tenfold of its distance. */
static double furthest(const km_driver_motion *d, int column) {
  static const double share = 0.25;
  return km_larger(share * fabs(km_driver_step_diverges(d, column)), km_driver_motion_furthest);
}

/* The coordinate of a slide that the step just tried leads so far away, so fast, that it leaves without bound; -1: none. */
static int leaves(const km_driver_motion *d, double h) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  double fastest = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    fastest = km_larger(fabs(d->c.next_t[k]), fastest);
  for (int k = 0; k < sub->columns && fastest > km_driver_motion_away; ++k)
    if (fabs(d->c.next_t[k]) > km_driver_motion_away && d->c.next_t[k] * h * km_driver_step_diverges(d, k) > 0.0 &&
        fabs(km_driver_step_diverges(d, k)) > km_driver_motion_away)
      return d->c.mechanism->column_coordinate[sub->column_start + k];
  return -1;
}

/* Where the driver has the only freedom Newton decides everything, and any start near enough serves. Where other freedoms
 * are left the prediction decides what they do: the path of least motion. False if h is too long for it. */
static bool predict(km_driver_motion *d, double h) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  bool reaches = true;
  d->drawn = false;
  d->strain = 0.0;
  if (is_alone(d) || d->c.steady.is_active)
    km_continuation_predict(&d->c, h, is_alone(d));
  else
    reaches = follow_path(d, h);
  for (int k = 0; k < sub->columns; ++k)
    if (!(fabs(d->c.move[k]) <= km_driver_motion_furthest) && !(fabs(d->c.move[k]) <= furthest(d, k)))
      return false;
  return reaches;
}

/* Where other freedoms are left, too few rows of a singular pose tell what they do. */
static bool may_be_singular(const km_driver_motion *d) {
  return !d->c.steady.is_active && !is_alone(d) && d->c.course.last_h == 0.0 &&
         d->c.course.reference.rank < km_driver_motion_substructure(d)->rows;
}

/* Does the way that these follow open the loops by far more than it errs? */
static bool opens(km_driver_motion *d) {
  static const double far_more = 100.0;
  const km_substructure *sub = km_driver_motion_substructure(d);
  double longest = 0.0;
  int worst;
  for (int k = 0; k < sub->columns; ++k)
    longest = km_larger(fabs(d->c.move[k]), longest);
  km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  double misfit = km_loops_residual(d->c.mechanism, d->c.state, sub, &worst);
  km_state_restore(d->c.state, sub, d->c.from);
  return misfit > far_more * (km_path_allowed * longest + km_path_grain) + d->c.mechanism->closure_tolerance;
}

/* Has the pose that was reached more independent rows? */
static bool leaves_singular(km_driver_motion *d) {
  const km_substructure *sub = km_driver_motion_substructure(d);
  km_partition *p = &d->c.state->partition[d->c.substructure];
  p->rows_only = p->sparse != NULL;
  km_search_pivots(d->c.mechanism, d->c.state, d->c.substructure, d->c.column,
                   km_rank_tolerance(d->c.mechanism, sub, 0.0));
  int rank = p->rank;
  p->rows_only = false;
  km_partition_copy_pivots(p, &d->c.course.reference);
  km_partition_refactor_full_pattern(p, km_state_jacobian(d->c.state, sub));
  return rank != d->c.course.reference.rank;
}

/* One predictor and its correction to s + h; the state is left where it ended. */
static km_attempt try_step(km_driver_motion *d, double h, double tightness) {
  if (d->bent > 0 && fabs(h) < km_driver_motion_creeping && may_be_singular(d)) /* too short to tell */
    return KM_ATTEMPT_BENT;
  if (!predict(d, h) || (may_be_singular(d) && !d->drawn && opens(d)))
    return KM_ATTEMPT_BENT;
  const km_step_terms terms = {
      .parameter = d->here.s + h,
      .most_correction = km_driver_motion_most_correction(
          tightness, km_step_length(d->c.mechanism, km_driver_motion_substructure(d), d->c.move)),
      .least_cosine = km_driver_motion_least_cosine(tightness),
      .least_rank = d->c.course.reference.rank,
      .leaves_end = d->here.stopped * h < 0.0};
  km_step_outcome fate = km_continuation_correct(&d->c, &terms);
  if (fate != KM_STEP_ACCEPTED)
    return fate == KM_STEP_OPEN ? KM_ATTEMPT_OPEN : KM_ATTEMPT_BENT;
  if (may_be_singular(d) && leaves_singular(d))
    return KM_ATTEMPT_BENT;
  bool changed = !d->passing && sign_changed(d);
  if (changed && fabs(h) > km_driver_motion_branch_width)
    return KM_ATTEMPT_BENT;
  d->here.crossings += changed;
  return KM_ATTEMPT_ACCEPTED;
}

/* May the step just tried be taken? Else `limit` is the coordinate that forbids it. */
static km_attempt judge(const km_driver_motion *d, double h, int *limit) {
  int passed = km_continuation_limit(&d->c, h), gone = passed < 0 ? leaves(d, h) : -1;
  *limit = passed >= 0 ? passed : gone >= 0 ? gone : *limit;
  return passed >= 0 ? KM_ATTEMPT_LIMITED : gone >= 0 ? KM_ATTEMPT_AWAY : KM_ATTEMPT_ACCEPTED;
}

/* Tries to advance by h. Restores the pose if refused. */
km_attempt km_driver_motion_advance(km_driver_motion *d, double h, double tightness, int *limit) {
  km_state_save(d->c.state, km_driver_motion_substructure(d), d->c.from);
  km_attempt result = try_step(d, h, tightness);
  result = result == KM_ATTEMPT_ACCEPTED ? judge(d, h, limit) : result;
  if (result != KM_ATTEMPT_ACCEPTED) {
    ++d->bent;
    km_continuation_reject(&d->c);
    return result;
  }
  d->bent = 0;
  d->here.stiff = d->drawn;
  km_continuation_accept(&d->c, h);
  d->here.s += h;
  d->here.known = true;
  return KM_ATTEMPT_ACCEPTED;
}
