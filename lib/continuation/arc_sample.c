/* Poses near the one to which a motion has been followed. */
#include "continuation/arc_motion.h"
#include "kinematics/loop_equations.h"

#include <string.h>

enum { MOST_PARTS = 16 }; /* of the way to a pose that no single step leads to */

static void write_rates(const km_arc_motion *f, const double *t, double *rates) {
  const km_mechanism *m = f->c.mechanism;
  memset(rates, 0, (size_t)m->coordinate_count * sizeof *rates);
  for (int k = 0; k < km_arc_motion_sub(f)->columns; ++k) {
    int c = m->column_coordinate[km_arc_motion_sub(f)->column_start + k];
    rates[c] = t[k] * m->unit[c];
  }
}

void km_arc_motion_tangent(const km_arc_motion *f, double *rates) {
  if (!f || !rates)
    return;
  write_rates(f, f->c.course.t, rates);
}

/* False when out of memory. */
static bool need_aside(km_arc_motion *f) {
  if (f->aside_pose)
    return true;
  double *pose = KM_ARENA_NEW(&f->arena, double, KM_SAVED_PER_COLUMN *(size_t)km_arc_motion_sub(f)->columns);
  if (!pose || !km_step_history_reserve(&f->aside, &f->c, &f->arena))
    return false;
  f->aside_pose = pose;
  return true;
}

/* By so many steps; the state stands at the end of the last one, and next_t is its tangent. */
static bool go_in_parts(km_arc_motion *f, double offset, int parts) {
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

/* The same with as many steps as it takes. The motion stays where it has come to; so does the state where nothing leads there. */
static bool visit_by_steps(km_arc_motion *f, double offset) {
  const km_substructure *sub = km_arc_motion_sub(f);
  bool there = false;
  if (!need_aside(f))
    return false;
  memcpy(f->aside_pose, f->c.from, KM_SAVED_PER_COLUMN * (size_t)sub->columns * sizeof *f->aside_pose);
  km_step_history_copy(&f->aside, &f->c.course, sub->columns);
  for (int parts = 2; !there && parts <= MOST_PARTS; parts *= 2) {
    there = go_in_parts(f, offset, parts);
    memcpy(f->c.from, f->aside_pose, KM_SAVED_PER_COLUMN * (size_t)sub->columns * sizeof *f->aside_pose);
    km_step_history_copy(&f->c.course, &f->aside, sub->columns);
  }
  if (!there)
    km_state_restore(f->c.state, sub, f->c.from);
  return there;
}

bool km_arc_motion_sample(km_arc_motion *f, double offset, double *rates) {
  if (!f || !rates || !isfinite(offset))
    return false;
  double reached;
  bool there = km_arc_motion_step(f, offset, &reached) || visit_by_steps(f, offset);
  if (there)
    write_rates(f, f->c.next_t, rates);
  km_state_invalidate_pivots(f->c.state, f->c.substructure);
  return there;
}

void km_arc_motion_restore(km_arc_motion *f) {
  if (!f)
    return;
  km_loops_restore_cached(f->c.mechanism, f->c.state, f->c.substructure, f->c.from);
}
