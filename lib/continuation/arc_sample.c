/* Probes of a followed motion: configurations near the present one, after which the motion returns exactly. */
#include "continuation/arc_motion.h"
#include "kinematics/loop_equations.h"

#include <string.h>

enum { MOST_PROBE_STEPS = 16 }; /* steps of a probe that one step does not reach */

void km_arc_motion_tangent(const km_arc_motion *f, double *rates) {
  if (!f || !rates)
    return;
  km_continuation_rates(&f->c, f->c.history.t, 1, 1.0, rates);
}

/* Advances by `offset` in equal steps; the state ends at the last one, next_t is its tangent. */
static bool step_in_parts(km_arc_motion *f, double offset, int parts) {
  double reached, left = offset;
  for (int part = 0; part < parts; ++part, left -= reached) {
    if (!km_arc_motion_step(f, left / (parts - part), &reached))
      return false;
    if (part + 1 == parts)
      break;
    km_continuation_accept(&f->c, reached);
    km_state_save(f->c.state, km_arc_motion_sub(f), f->c.from);
  }
  return true;
}

/* Advances by `offset` in 2, 4, … 16 steps. The motion keeps its configuration and history; so does the state if no
 * number of steps succeeds. */
static bool sample_by_steps(km_arc_motion *f, double offset) {
  const km_substructure *sub = km_arc_motion_sub(f);
  bool is_reached = false;
  memcpy(f->probe_start, f->c.from, KM_SAVED_PER_COLUMN * (size_t)sub->columns * sizeof *f->probe_start);
  km_step_history_copy(&f->probe_history, &f->c.history, sub->columns);
  for (int parts = 2; !is_reached && parts <= MOST_PROBE_STEPS; parts *= 2) {
    is_reached = step_in_parts(f, offset, parts);
    memcpy(f->c.from, f->probe_start, KM_SAVED_PER_COLUMN * (size_t)sub->columns * sizeof *f->probe_start);
    km_step_history_copy(&f->c.history, &f->probe_history, sub->columns);
  }
  if (!is_reached)
    km_state_restore(f->c.state, sub, f->c.from);
  return is_reached;
}

bool km_arc_motion_sample(km_arc_motion *f, double offset, double *rates) {
  if (!f || !rates || !isfinite(offset))
    return false;
  double reached;
  bool is_reached = km_arc_motion_step(f, offset, &reached) || sample_by_steps(f, offset);
  if (is_reached)
    km_continuation_rates(&f->c, f->c.next_t, 1, 1.0, rates);
  km_state_invalidate_pivots(f->c.state, f->c.substructure);
  return is_reached;
}

void km_arc_motion_restore(km_arc_motion *f) {
  if (!f)
    return;
  km_loops_restore_cached(f->c.mechanism, f->c.state, f->c.substructure, f->c.from);
}
