/* Closed cycles of a continuation by arc length (theory 4.9): the motion returns to its origin within 1e-9, full turns
 * of hinges not counted. */
#include "base/number/tolerances.h"
#include "continuation/arc_motion.h"
#include "kinematics/loop_closing.h"

#include <string.h>

/* Computes the displacement from the origin to the state's configuration, full turns of hinges removed. */
static void difference_from_origin(km_arc_motion *f, double *displacement) {
  const km_mechanism *m = f->c.mechanism;
  km_state_difference(f->c.state, km_arc_motion_sub(f), f->origin, displacement);
  for (int k = 0; k < km_arc_motion_sub(f)->columns; ++k)
    if (km_coordinate_turns(m, m->column_coordinate[km_arc_motion_sub(f)->column_start + k]))
      displacement[k] -= 2.0 * M_PI * round(displacement[k] / (2.0 * M_PI));
}

bool km_arc_motion_passes_origin(km_arc_motion *f, double length) {
  double *displacement = f->c.work;
  if (f->cycle > 0.0)
    return false;
  difference_from_origin(f, displacement);
  double after = km_continuation_dot(&f->c, f->origin_t, displacement);
  return f->s - f->origin_s + length > 2.0 * km_longest_arc_step && after >= -1e-12 && after <= 1.5 * length &&
         km_continuation_dot(&f->c, f->origin_t, f->c.next_t) > 0.9 &&
         km_continuation_dot(&f->c, displacement, displacement) < 4.0 * length * length;
}

bool km_arc_motion_meet_origin(km_arc_motion *f, double length) {
  double *displacement = f->c.work, reached = length;
  difference_from_origin(f, displacement);
  for (int i = 0; i < 12; ++i) {
    double along = km_continuation_dot(&f->c, f->origin_t, displacement);
    if (i > 0 && fabs(along) < 1e-14)
      break;
    if (reached - along <= 0.0 || !km_arc_motion_step(f, reached - along, &reached))
      return false;
    difference_from_origin(f, displacement);
  }
  if (km_continuation_dot(&f->c, displacement, displacement) > km_relative_zero * km_relative_zero)
    return false;
  km_arc_motion_accept(f, reached);
  f->cycle = f->s - f->origin_s;
  f->closed = true;
  return true;
}

bool km_arc_motion_closed(const km_arc_motion *f) {
  if (!f)
    return false;
  return f->closed;
}

double km_arc_motion_cycle_length(const km_arc_motion *f) {
  if (!f)
    return 0.0;
  return f->cycle;
}

void km_arc_motion_continue_past_cycle(km_arc_motion *f) {
  if (!f)
    return;
  f->closed = false;
}
