/* Tangents of finite motions: regular configurations, random starts on the tangent cone (docs/theory.md 5.2-5.5). */
#include "base/number/tolerances.h"
#include "kinematics/loop_closing.h"
#include "local/local_private.h"

#include <string.h>

/* Exact data: one random tangent decides, in one sense, since the misfit is analytic on the manifold of the primary
 * equations. Its chord decides between it and a neighbouring motion, or, where the curvature is large, its secant. */
static bool is_exact_family(km_local *l) {
  if (km_local_follow(l, l->direction, 1.0).verdict < KM_TANGENT_CONFIRMED || km_local_has_dropped(l))
    return false;
  return km_local_chord_agrees(l, l->direction) ||
         (km_local_follow_both_senses(l, l->direction).verdict >= l->min_verdict &&
          km_local_secant_agrees(l, l->direction));
}

/* True if a random tangent and its secant are finite and the number of tangents stays. */
static bool is_sample_finite(km_local *l, uint64_t *random) {
  bool is_exact = km_local_is_exact(l);
  if (!km_local_draw(l, random, l->a) ||
      (is_exact && (l->has_basis ? l->freedom > 1 && km_local_is_small(l->sub) : l->freedom > KM_MANY_VECTORS) &&
       km_local_violates_second_order(l, l->a)))
    return false;
  km_local_direction(l, l->a, l->direction);
  if (is_exact && l->freedom > 1)
    return is_exact_family(l);
  return km_local_is_finite(l, l->a) && (l->freedom == 1 || !km_local_has_dropped(l));
}

/* All tangents are finite if J has full row rank. Otherwise random tangents show it: one of exact data, else as many as
 * basis vectors and combinations of them. */
bool km_local_is_regular(km_local *l) {
  uint64_t random = 1;
  int samples = km_local_is_exact(l) || l->freedom == 1 ? 1 : l->has_basis ? 2 * l->freedom : 2;
  bool is_regular = true;
  for (int i = 0; i < samples && is_regular && l->has_redundant_rows; ++i)
    is_regular = is_sample_finite(l, &random);
  return is_regular;
}

/* True if two tangents can be one. They are known as secants only if no condition is significant. Otherwise tangents
 * that are close and each satisfy the conditions are two if their mean violates them. */
static bool is_one_tangent(km_local *l, const double *a, const double *b) {
  if (!km_local_is_significant(l) || !l->has_basis)
    return km_local_is_same(l, a, b, km_local_is_significant(l) ? km_tangent_tolerance : km_secant_tolerance);
  if (!km_local_is_same(l, a, b, km_tangent_tolerance))
    return false;
  double *mean = l->work, along = 0.0;
  for (int i = 0; i < l->size; ++i)
    along += a[i] * b[i];
  for (int i = 0; i < l->size; ++i)
    mean[i] = a[i] + copysign(1.0, along) * b[i];
  km_local_normalise(l, mean);
  double violation = fmax(km_local_violation(l, a), km_local_violation(l, b));
  return km_local_violation(l, mean) <= km_significant_ratio * fmax(violation, km_relative_zero);
}

/* True if the tangent `a` is among the known ones. */
static bool is_known_tangent(km_local *l, const double *known, int count) {
  for (int i = 0; i < count; ++i)
    if (is_one_tangent(l, known + (size_t)i * (size_t)l->size, l->a))
      return true;
  return false;
}

/* Follows the direction `a`. If it is refuted only at higher order, closing can have led to a nearby motion: its secant
 * replaces `a` and is followed, up to five times. By columns, where that is costly, only if the secant disagrees. */
static km_followed_tangent follow_with_secants(km_local *l) {
  enum { MAX_SECANT_STEPS = 5 };
  km_followed_tangent found;
  for (int i = 0; i < MAX_SECANT_STEPS; ++i) {
    km_local_direction(l, l->a, l->direction);
    found = km_local_follow_both_senses(l, l->direction);
    if (found.verdict < l->min_verdict || (!l->has_basis && km_local_secant_agrees(l, l->direction)))
      return found;
    memcpy(l->previous, l->a, (size_t)l->size * sizeof *l->a);
    if (km_local_coefficients(l, l->secant, l->a) == 0.0 || !km_local_solve_second_order(l, l->a) ||
        km_local_is_same(l, l->a, l->previous, km_tangent_tolerance))
      break;
  }
  memcpy(l->a, l->previous, (size_t)l->size * sizeof *l->a);
  return found;
}

/* Number of starts: 40 times the larger of the freedom and the number of known tangents, since many known branches
 * indicate further ones. Many freedoms: each start takes a few dozen sparse factorisations. */
static int count_starts(const km_local *l, int known) {
  enum { MAX_STARTS_TIMES_COLUMNS = 1200, MIN_STARTS = 2 };
  int starts = MAX_STARTS_TIMES_COLUMNS / l->sub->columns;
  if (l->has_basis)
    return KM_STARTS_PER_FREEDOM * (known > l->freedom ? known : l->freedom);
  return starts > MIN_STARTS ? starts : MIN_STARTS;
}

/* Draws a start. The first one of few is uniform, so that equal loops move alike. */
static bool start_tangent(km_local *l) {
  if (l->starts++ > 0 || l->has_basis)
    return km_local_draw(l, &l->random, l->a);
  for (int i = 0; i < l->size; ++i)
    l->a[i] = 1.0;
  return km_local_normalise(l, l->a) > 0.0;
}

/* Finds a new branch tangent from random starts on the tangent cone. A single tangent was followed as it is. */
bool km_local_find_next(km_local *l, const double *known, int count, double *length) {
  while (l->freedom > 1 && l->starts < count_starts(l, count)) {
    if (!start_tangent(l) || !km_local_solve_second_order(l, l->a) || is_known_tangent(l, known, count))
      continue;
    const bool before = l->has_undecided;
    l->has_undecided = false;
    km_followed_tangent found = follow_with_secants(l);
    int dimension = l->has_undecided ? km_local_dimension_bound(l, l->a) : 0;
    l->undecided_dimension = dimension > l->undecided_dimension ? dimension : l->undecided_dimension;
    l->has_undecided = l->has_undecided || before;
    *length = found.length;
    if (found.verdict >= l->min_verdict && !is_known_tangent(l, known, count))
      return true;
  }
  return false;
}
