/* Singular poses that a drive passes: branch points that it crosses, and others that it leaps over. */
#include "kinematics/drive_step.h"

#include "base/larger.h"
#include "kinematics/closure.h"
#include "kinematics/curve.h"
#include "kinematics/loops.h"

#include <string.h>

/* Passes a singular pose at `target` along the smooth branch: the pose between two regular ones on either
 * side, by the cubic through both. Near it Newton finds no more than half the digits. */
bool km_drive_cross(km_drive *d, double target, int *limit) {
  const km_substructure *sub = km_drive_driven(d);
  double side = target > d->here.s ? 1.0 : -1.0;
  double gap = target - side * km_drive_crossing - d->here.s;
  if (gap != 0.0 && km_drive_advance(d, gap, km_drive_tightness, limit) != KM_ATTEMPT_ACCEPTED)
    return false;
  double h = target + side * km_drive_crossing - d->here.s, near = target - d->here.s;
  km_state_save(d->c.state, sub, d->near);
  d->passing = true;
  km_attempt beyond = km_drive_advance(d, h, km_drive_crossing_tightness, limit);
  d->passing = false;
  if (beyond != KM_ATTEMPT_ACCEPTED)
    return false;
  /* Accepting it has moved its tangent and its move to last_t, last_move. */
  km_state_save(d->c.state, sub, d->far);
  km_state_restore(d->c.state, sub, d->near);
  km_curve_between(sub->columns, h, d->c.course.last_move, d->c.course.last_t, d->c.course.t, near, d->c.move,
                   d->c.next_t);
  km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
  km_continuation_place(&d->c, target);
  km_loops_update(d->c.mechanism, d->c.state, sub);
  km_state_forget_pivots(d->c.state, d->c.substructure);
  int worst;
  if (km_loops_residual(d->c.mechanism, d->c.state, sub, &worst) > km_drive_closed) {
    km_state_restore(d->c.state, sub, d->far); /* a regular pose, if on the other side */
    return false;
  }
  memcpy(d->c.course.t, d->c.next_t, (size_t)sub->columns * sizeof *d->c.course.t);
  d->here.crossings++;
  d->here.s = target;
  km_course_begin(&d->c.course, sub->columns);
  return true;
}

/* At a toggle the rates of others grow without bound: by so much, in radians or sizes of the substructure for each of the driver's, at the
 * distance at which an end is located. Where they don't, the mechanism is singular, but not there that it turns back. */
static bool is_toggle(const km_drive *d) {
  static const double beyond_bounds = 1e3;
  double fastest = 0.0;
  for (int k = 0; k < km_drive_driven(d)->columns; ++k)
    fastest = km_larger_or_nan(fabs(d->c.course.t[k]), fastest);
  return !(fastest < beyond_bounds);
}

/* Where a step of a length that tells poses apart is refused, the present pose may still be away from what refuses it. */
void km_drive_remember_place(km_drive *d, double h) {
  static const double long_enough = 5e-3;
  const km_course *course = &d->c.course;
  if (fabs(h) < long_enough)
    return;
  km_state_save(d->c.state, km_drive_driven(d), d->regular.pose);
  d->regular.s = d->here.s;
  d->regular.h = course->last_h;
  memcpy(d->regular.move, course->last_move, (size_t)km_drive_driven(d)->columns * sizeof *course->last_move);
}

/* Back to the place that was remembered, or to the one a step before it. */
static bool go_back(km_drive *d, bool before) {
  const km_substructure *sub = km_drive_driven(d);
  const km_drive_regular *r = &d->regular;
  km_state_restore(d->c.state, sub, r->pose);
  d->here.s = r->s;
  if (before) {
    for (int k = 0; k < sub->columns; ++k)
      d->c.move[k] = -r->move[k];
    km_state_move(d->c.mechanism, d->c.state, sub, d->c.move);
    d->here.s -= r->h;
    km_continuation_place(&d->c, d->here.s);
  }
  return km_drive_start(d);
}

/* Does the motion behind a singular pose at `s` come back to it? Else there is a gap between two toggles. The drive stays behind. */
static bool comes_back(km_drive *d, double s, int *limit) {
  static const double near_enough = 1e-5, no_step = 1e-7;
  const km_drive_place behind = d->here;
  km_state_save(d->c.state, km_drive_driven(d), d->far);
  double step = fabs(s - d->here.s), left = step;
  while (left > near_enough && step > no_step) {
    step = km_smaller(step, 0.5 * left);
    bool taken = km_drive_advance(d, copysign(step, s - d->here.s), km_drive_tightness, limit) == KM_ATTEMPT_ACCEPTED;
    step *= taken ? 2.0 : 0.5;
    left = fabs(s - d->here.s);
  }
  km_state_restore(d->c.state, km_drive_driven(d), d->far);
  d->here = behind;
  return left <= near_enough && km_drive_start(d);
}

/* Over a singular pose at `s`, as far behind it as it is away. */
static bool leap(km_drive *d, double s, double target, int *limit) {
  double way = 2.0 * (s - d->here.s);
  way = fabs(way) < fabs(target - d->here.s) ? way : target - d->here.s;
  d->passing = true;
  bool over = way * (target - s) > 0.0 &&
              km_drive_advance(d, way, km_drive_crossing_tightness, limit) == KM_ATTEMPT_ACCEPTED && km_drive_start(d);
  d->passing = false;
  return over;
}

/* Steps have become too short at a singular pose that is no toggle: many motions may meet there, between which short steps can't tell.
 * False, with the state where it was, if no step from a place before it leads over it. */
bool km_drive_leap_over(km_drive *d, double target, int *limit) {
  const km_drive_place here = d->here;
  if (is_toggle(d) || d->regular.s == d->here.s || !(fabs(d->regular.s - d->here.s) <= km_drive_longest))
    return false;
  km_state_save(d->c.state, km_drive_driven(d), d->near);
  for (int before = 0; before < (d->regular.h != 0.0 ? 2 : 1); ++before)
    if (go_back(d, before) && leap(d, here.s, target, limit) && comes_back(d, here.s, limit)) {
      d->here.crossings++;
      return true;
    }
  km_state_restore(d->c.state, km_drive_driven(d), d->near);
  d->here = here;
  d->here.known = false;
  return false;
}
