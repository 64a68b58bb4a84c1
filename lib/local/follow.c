/* Decides whether a tangent belongs to a finite motion, by the order of contact (docs/theory.md 5.3).
 *
 *   follow: q₀ + h a, closed with the fastest coordinate fixed;  h: 1e-3 … 0.05, up to 0.3 of that coordinate
 *   misfit(t) ~ C t^(n+1) for a contact of order n;   a finite motion leaves none, rounded data about ε
 *   confirmed: followed by 0.3, misfit <= tol = max(closure tolerance, 3 misfit(q₀))
 *   refuted  : misfit > 100 tol and order >= 1.5; or exact data and order >= 3.5, or exact data that end before 4e-3
 *   lost     : data not exact, ends before 4e-3;   undecided: otherwise */
#include "base/number/tolerances.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/local_private.h"

static const double confirmed_length = 0.3; /* scaled; length of a confirmed tangent in each sense */
static const double min_order = 1.5;        /* order of contact that refutes, for a misfit far above the tolerance */
static const double min_order_of_exact_data = 3.5; /* order of contact that rounding of exact data does not
                                                             * produce */
static const double max_order = 12.0;              /* a misfit that grows with a higher order has left the curve */

enum { MAX_SAMPLES = 400 };

/* Misfit along the followed curve: the second largest value up to each length, since a single one may be a bad
 * closure. */
typedef struct misfit_record {
  int count;
  double largest, length[MAX_SAMPLES], worst[MAX_SAMPLES];
} misfit_record;

/* Appends the misfit at a length, without its largest outlier. */
static void append_misfit(misfit_record *r, double length, double misfit) {
  double last = r->count ? r->worst[r->count - 1] : 0.0;
  r->length[r->count] = length;
  r->worst[r->count++] = fmax(last, fmin(misfit, r->largest));
  r->largest = fmax(r->largest, misfit);
}

/* Largest order of growth of the misfit, log(misfit ratio)/log(length ratio) between half a length and the length,
 * over lengths at which the misfit exceeds rounding. */
static double order_of_contact(const misfit_record *r, double start) {
  double largest = 0.0;
  for (int i = 1; i < r->count; ++i) {
    int midpoint = i;
    while (midpoint >= 0 && r->length[midpoint] > 0.5 * r->length[i])
      --midpoint;
    if (midpoint < 0 || r->worst[i] < km_exact_misfit || r->worst[i] < 1e3 * start)
      continue;
    double before = fmax(r->worst[midpoint], 1e-3 * km_exact_misfit);
    largest = fmax(largest, log(r->worst[i] / before) / log(r->length[i] / r->length[midpoint]));
  }
  return largest;
}

/* Column with the largest move, which is returned. */
static double fastest_column(const double *move, int columns, int *column) {
  double largest = 0.0;
  *column = 0;
  for (int k = 0; k < columns; ++k)
    if (fabs(move[k]) > largest) {
      largest = fabs(move[k]);
      *column = k;
    }
  return largest;
}

/* Column to fix in the next closing: the fastest. The present one stays while it moves more than 0.3 of the fastest, so
 * that the pivots can be reused. */
static int choose_fixed_column(const km_local *l, int driver) {
  int column;
  double largest = fastest_column(l->move, l->sub->columns, &column);
  return driver >= 0 && fabs(l->move[driver]) > 0.3 * largest ? driver : column;
}

/* Displacement that the misfit of the configuration can cause if other rows become the primary ones. */
static double repivot_slack(const km_local *l) {
  const km_factor *p = l->s->factor[l->index];
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  return km_factor_rank(p) ? 3.0 * l->residual * evidence.scale / evidence.smallest_pivot_at_search : 0.0;
}

/* Basis that steps need: with many freedoms the primary rows suffice. */
static km_factor_basis needed_basis(const km_factor *p) {
  return km_factor_freedom(p) > KM_MAX_BASIS_FREEDOM ? KM_BASIS_NONE : KM_BASIS_SHORT;
}

/* True if the present pivots suffice for the next step. Further on more rows can be independent and fewer motions
 * remain. */
static bool are_pivots_sufficient(const km_local *l, const km_factor *p) {
  const bool has_null_vectors = km_factor_has_null_vectors(p);
  return (has_null_vectors || needed_basis(p) == KM_BASIS_NONE) &&
         (km_factor_rank(p) == l->sub->rows || (km_factor_freedom(p) <= 1 && has_null_vectors));
}

/* Takes the step `move` and closes the loops with the column `driver` fixed. False, and the state is restored, if the
 * primary rows do not close nearby or the misfit grows too fast. */
static bool take_step(km_local *l, int driver, double length, double *misfit) {
  km_closure evidence;
  int column;
  double moved = fastest_column(l->move, l->sub->columns, &column);
  double largest =
      length > 0.0 ? 3.0 * fmax(*misfit, km_exact_misfit) * pow(1.0 + moved / length, max_order) : HUGE_VAL;
  const km_factor *p = l->s->factor[l->index];
  const km_pivoting pivoting = {.driver = driver, .driver_never_pivot = true, .basis = needed_basis(p)};
  km_state_save(l->s, l->sub, l->last);
  km_state_move(l->m, l->s, l->sub, l->move);
  double step_length = km_step_length(l->m, l->sub, l->move);
  bool closed = km_loops_close_by(l->m, l->s, l->index, &pivoting, &evidence) != KM_OPEN;
  if (closed && evidence.residual <= largest &&
      evidence.correction <=
          (length > 0.0 ? km_correction_ratio : km_strict_correction_ratio) * step_length + repivot_slack(l)) {
    *misfit = evidence.residual;
    if (!are_pivots_sufficient(l, p))
      km_state_invalidate_pivots(l->s, l->index);
    return true;
  }
  km_state_restore(l->s, l->sub, l->last);
  return false;
}

static void scale_move(km_local *l, double factor) {
  for (int c = 0; c < l->sub->columns; ++c)
    l->move[c] *= factor;
}

/* Predicts the next move of size h: along the tangent (null vector of J) if there is one freedom, with the fixed
 * coordinate as its independent one; else along the last move (secant). */
static void predict(km_local *l, int driver, double h) {
  const km_factor *p = l->s->factor[l->index];
  int column, n = l->sub->columns;
  double *t = l->tangent;
  if (km_factor_freedom(p) == 1 && km_factor_column_order(p)[km_factor_rank(p)] == driver &&
      km_factor_has_null_vectors(p)) {
    km_factor_null_vector(p, driver, t);
    double sign = copysign(1.0, km_step_dot(l->m, l->sub, t, l->move)), size = fastest_column(t, n, &column);
    for (int c = 0; c < n && isfinite(size); ++c)
      l->move[c] = sign * t[c] / size;
  }
  scale_move(l, h / fastest_column(l->move, n, &column));
}

bool km_local_is_exact(const km_local *l) {
  return !l->m->closure_tolerance_given && l->residual < km_exact_misfit;
}

/* Updates the chord from q₀ as long as the curve is short and straight: a chord that leaves the direction of the last
 * move is no estimate of the tangent. */
static void update_chord(const km_local *l, double length) {
  bool is_straight = length == 0.0 || km_step_dot(l->m, l->sub, l->chord, l->move) >=
                                          km_min_direction_cosine * km_step_length(l->m, l->sub, l->chord) *
                                              km_step_length(l->m, l->sub, l->move);
  if (length < 20.0 * km_singular_step && is_straight)
    km_state_difference(l->s, l->sub, l->origin, l->chord);
}

/* Verdict from the length and the order of contact, as in the head of this file. */
static km_tangent_verdict decide_verdict(const km_local *l, const misfit_record *r, double tolerance,
                                         bool is_complete) {
  double length = r->count ? r->length[r->count - 1] : 0.0, misfit = r->count ? r->worst[r->count - 1] : 0.0;
  bool exact = km_local_is_exact(l);
  if (length < 4.0 * km_singular_step)
    return exact ? KM_TANGENT_REFUTED : KM_TANGENT_LOST;
  double order = order_of_contact(r, l->residual);
  if ((misfit > km_significant_ratio * tolerance && order >= min_order) || (exact && order >= min_order_of_exact_data))
    return KM_TANGENT_REFUTED;
  return is_complete && misfit <= tolerance ? KM_TANGENT_CONFIRMED : KM_TANGENT_UNDECIDED;
}

/* Follows a tangent with adaptive steps and decides whether it belongs to a finite motion. */
km_followed_tangent km_local_follow(km_local *l, const double *direction, double sign) {
  misfit_record r = {0};
  int column, columns = l->sub->columns, driver = -1;
  double start = l->residual, tolerance = fmax(l->m->closure_tolerance, 3.0 * start);
  double first = fmin(fmax(km_singular_step, km_significant_ratio * start), km_longest_arc_step), h = first;
  double misfit = 0.0, length = 0.0, opening_length = HUGE_VAL; /* length at which the misfit exceeds the tolerance */
  km_followed_tangent result = {0};
  double size = fastest_column(direction, columns, &column);
  for (int c = 0; c < columns; ++c)
    l->move[c] = sign * h * direction[c] / size;
  km_state_restore(l->s, l->sub, l->origin);
  km_state_invalidate_pivots(l->s, l->index);
  /* The curve is followed beyond that length, so that the order of contact can be estimated. */
  while (length < confirmed_length && !(length > 2.0 * opening_length && misfit > km_significant_ratio * tolerance) &&
         r.count < MAX_SAMPLES && h >= (length > 0.0 ? 1e-3 * km_singular_step : 0.1 * first)) {
    driver = choose_fixed_column(l, driver);
    if (!take_step(l, driver, length, &misfit)) {
      scale_move(l, 0.5);
      h *= 0.5;
      continue;
    }
    km_state_difference(l->s, l->sub, l->last, l->move);
    double moved = fastest_column(l->move, columns, &column);
    update_chord(l, length);
    length += moved;
    append_misfit(&r, length, misfit);
    if (misfit > tolerance)
      opening_length = fmin(opening_length, length);
    else if (opening_length == HUGE_VAL)
      result.length += km_step_length(l->m, l->sub, l->move);
    h = fmin(1.5 * h, km_longest_arc_step);
    predict(l, driver, h);
  }
  km_state_invalidate_pivots(l->s, l->index);
  result.verdict = decide_verdict(l, &r, tolerance, length >= confirmed_length);
  return result;
}

/* Compares the freedom at the end of a followed curve with that of the configuration. */
bool km_local_has_dropped(km_local *l) {
  km_loops_update(l->m, l->s, l->sub);
  double residual = km_loops_residual(l->m, l->s, l->sub);
  const km_pivoting pivoting = {.driver = KM_NO_DRIVER, .basis = needed_basis(l->s->factor[l->index])};
  km_search_pivots_by(l->m, l->s, l->index, &pivoting, km_rank_tolerance(l->m, l->sub, residual));
  bool fewer = km_factor_freedom(l->s->factor[l->index]) < l->freedom + l->passive_count;
  km_state_invalidate_pivots(l->s, l->index);
  return fewer;
}

/* Averages the chords ahead and back into the secant: the curvature of the motion cancels to second order. */
static void add_to_secant(km_local *l, int sign) {
  double length = km_step_length(l->m, l->sub, l->chord);
  for (int c = 0; c < l->sub->columns; ++c)
    l->secant[c] = (sign > 0 ? 0.0 : l->secant[c]) + 0.5 * sign * l->chord[c] / length;
}

/* Follows a tangent ahead and back: the lower verdict and the shorter length. */
km_followed_tangent km_local_follow_both_senses(km_local *l, const double *direction) {
  km_followed_tangent worse = {HUGE_VAL, KM_TANGENT_CONFIRMED};
  for (int sign = 1; sign >= -1; sign -= 2) {
    km_followed_tangent followed = km_local_follow(l, direction, sign);
    l->has_undecided =
        l->has_undecided || followed.verdict == KM_TANGENT_LOST || followed.verdict == KM_TANGENT_UNDECIDED;
    if (followed.verdict < l->min_verdict)
      return (km_followed_tangent){0.0, followed.verdict};
    add_to_secant(l, sign);
    if (sign > 0)
      km_state_save(l->s, l->sub, l->end_ahead);
    worse = (km_followed_tangent){fmin(worse.length, followed.length),
                                  followed.verdict < worse.verdict ? followed.verdict : worse.verdict};
  }
  return worse;
}

/* True if a unit direction and a chord agree up to the curvature of the curve. */
static bool is_along(const km_local *l, const double *direction, const double *chord) {
  double length = km_step_length(l->m, l->sub, chord);
  return length > 0.0 && 1.0 - fabs(km_step_dot(l->m, l->sub, chord, direction)) / length <= km_secant_tolerance;
}

bool km_local_secant_agrees(const km_local *l, const double *direction) {
  return l->freedom == 1 || is_along(l, direction, l->secant);
}

bool km_local_chord_agrees(const km_local *l, const double *direction) {
  return l->freedom == 1 || is_along(l, direction, l->chord);
}

bool km_local_is_finite(km_local *l, const double *a) {
  km_local_direction(l, a, l->direction);
  return km_local_follow_both_senses(l, l->direction).verdict >= l->min_verdict &&
         km_local_secant_agrees(l, l->direction);
}
