/* Step control of a continuation by arc length (theory 4.9): halves on rejection, doubles up to 0.05; stops at limits,
 * locates branch points by the sign of g, and detects closed cycles. */
#include "base/number/tolerances.h"
#include "kmech/continuation.h"

#include "continuation/arc_motion.h"
#include "kinematics/loop_closing.h"

/* Refines the configuration at the limit that ended the motion. */
static void refine_limit(km_arc_motion *f) {
  double reached;
  for (int round = 0; round < 2; ++round) {
    double h = km_continuation_step_to_limit(&f->c, f->limit);
    if (h == 0.0 || !km_arc_motion_step(f, h, &reached))
      return;
    km_arc_motion_accept(f, reached);
  }
}

/* Takes one controlled step of at most `most`; false if the motion ends. */
static bool advance_one_step(km_arc_motion *f, double most) {
  double first_h = most / ceil(most / f->largest * (1.0 - km_relative_zero)); /* equal steps avoid a short last one */
  for (double h = first_h; h >= fmin(km_relative_zero, most); h *= 0.5) {
    double length;
    if (!(h == most ? km_arc_motion_step(f, h, &length) : km_arc_motion_try(f, h, &length)) ||
        length > most * (1.0 + km_relative_zero))
      continue;
    if (f->freedom == 1) {
      double g = km_arc_motion_branch_function_after_step(f);
      if (g * f->g < 0.0 && length > KM_SINGULAR_BRACKET)
        continue;
      if (g * f->g < 0.0) {
        km_arc_motion_locate_branch(f, length, g);
        if (!km_arc_motion_step(f, length, &length))
          continue;
      }
    }
    if (km_arc_motion_passes_origin(f, length)) {
      if (km_arc_motion_meet_origin(f, length))
        return true;
      if (!km_arc_motion_step(f, length, &length))
        continue;
    }
    f->limit = km_continuation_limit(&f->c, length);
    if (f->limit >= 0) {
      km_continuation_reject(&f->c);
      continue;
    }
    km_arc_motion_accept(f, length);
    f->largest = fmin(km_longest_arc_step, h == first_h ? 2.0 * f->largest : h);
    return true;
  }
  if (f->limit >= 0)
    refine_limit(f);
  return false;
}

static void notify_observer(const km_arc_motion *f) {
  if (!f->observer.notify)
    return;
  km_arc_motion_tangent(f, f->observer.rates);
  f->observer.notify(f->observer.self, f->s, f->observer.rates);
}

km_status km_arc_motion_advance(km_arc_motion *f, double length) {
  if (!f || !(length > 0.0 && length <= KM_MAX_ARCLENGTH))
    return KM_USAGE;
  double target = f->s + length;
  f->branched = false;
  const double near = fmax(1e-10 * length, KM_SHORTEST_ARC);
  while (!f->closed && !f->branched && target - f->s > near) {
    if (!advance_one_step(f, target - f->s))
      return KM_PARTIAL;
    if (target - f->s > near)
      notify_observer(f);
  }
  return KM_OK;
}
