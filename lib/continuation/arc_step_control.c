/* Step control of a motion by arc length: step size, rejection, limits, branch points and cycles on the way. */
#include "kmech/continuation.h"

#include "continuation/arc_motion.h"

static const double longest = 0.05;    /* of a step: the arc of the cubic between two poses errs by about h⁵/1000 */
static const double shortest = 1e-9;   /* of a step: below, the motion ends */
static const double furthest = 1000.0; /* of one advance */
static const double narrow = 4e-3;     /* width to which a branch point is bracketed before it is interpolated */

/* Goes as far as the limit of coordinate c allows, less than `length`. */
static void stop_at_limit(km_arc_motion *f, int c, double length) {
  double inside = 0.0, outside = length, reached;
  f->limit = c;
  for (int i = 0; i < 60 && outside - inside > 1e-11; ++i) {
    double middle = 0.5 * (inside + outside);
    if (km_arc_motion_step(f, middle, &reached) && km_continuation_limit(&f->c, middle) < 0)
      inside = middle;
    else
      outside = middle;
  }
  if (inside > 0.0 && km_arc_motion_step(f, inside, &reached))
    km_arc_motion_accept(f, reached);
  else
    km_state_restore(f->c.state, km_arc_motion_sub(f), f->c.from);
}

/* One controlled step of at most `most`; false if the motion can't go on. */
static bool one_step(km_arc_motion *f, double most) {
  double first = most / ceil(most / f->largest * (1.0 - 1e-9)); /* equal steps leave no crumb at the end */
  for (double h = first; h >= fmin(shortest, most); h *= 0.5) {
    double length;
    if (!(h == most ? km_arc_motion_step(f, h, &length) : km_arc_motion_try(f, h, &length)) ||
        length > most * (1.0 + 1e-9))
      continue;
    if (f->freedom == 1) {
      double g = km_arc_motion_saved_g(f);
      if (g * f->g < 0.0 && length > narrow)
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
    int limit = km_continuation_limit(&f->c, length);
    if (limit >= 0) {
      stop_at_limit(f, limit, length);
      return false;
    }
    km_arc_motion_accept(f, length);
    f->largest = fmin(longest, h == first ? 2.0 * f->largest : h);
    return true;
  }
  return false;
}

static void tell(const km_arc_motion *f) {
  if (!f->watch.stepped)
    return;
  km_arc_motion_tangent(f, f->watch.rates);
  f->watch.stepped(f->watch.self, f->s, f->watch.rates);
}

km_status km_arc_motion_advance(km_arc_motion *f, double length) {
  if (!f || !(length > 0.0 && length <= furthest))
    return KM_USAGE;
  double target = f->s + length;
  f->branched = false;
  const double near = fmax(1e-10 * length, KM_FINEST_ARC);
  while (!f->closed && !f->branched && target - f->s > near) {
    if (!one_step(f, target - f->s))
      return KM_PARTIAL;
    if (target - f->s > near)
      tell(f);
  }
  return KM_OK;
}
