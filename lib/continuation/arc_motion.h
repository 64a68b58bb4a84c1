/* Continuation by arc length (theory 4.9): data and operations of a followed motion. Private to
 * continuation/, sweep/ and space/. */
#ifndef KM_CONTINUATION_ARC_MOTION_H
#define KM_CONTINUATION_ARC_MOTION_H

#include "continuation/node_curve.h"
#include "kmech/continuation.h"

#define KM_SHORTEST_ARC  1e-13  /* shortest arc length that rounding resolves */
#define KM_MAX_ARCLENGTH 1000.0 /* longest advance, for the run time */

struct km_arc_motion {
  km_arena arena;
  km_continuation c; /* c.from is the present configuration of the motion */
  int freedom;
  int start_branches; /* branches at the starting configuration; 0: it is regular */
  double s, largest;  /* arc length so far; step size of the step control */
  /* arc length at the origin of the cycle: the start or, from a branch point, the first configuration after it */
  double origin_s;
  double cycle;                   /* length of the closed cycle; 0: none */
  bool closed, is_origin_pending; /* the next accepted configuration becomes the origin */
  int limit;                      /* coordinate whose limit ended the motion, -1 */
  double *origin_t, *branch_t;
  double *origin, *branch_pose; /* configurations as km_state_save: origin, branch point */
  km_node_curve curve;          /* interpolates the motion around the branch point */
  /* branch function g (arc_step.c) at the present configuration, with the history's pivots */
  double g;
  km_branch_point branch; /* branch point passed in the last advance, if `branched` */
  bool branched;
  km_step_observer observer;
  km_step_history probe_history; /* history and configuration that a probe of several steps restores */
  double *probe_start;
};

static inline const km_substructure *km_arc_motion_sub(const km_arc_motion *follow) {
  return km_continuation_sub(&follow->c);
}

/* Sets the observer of intermediate steps. */
static inline void km_arc_motion_set_observer(km_arc_motion *f, km_step_observer observer) {
  f->observer = observer;
}

/* Attempts a step of about h from c.from. On success the state is at its end, next_t is the tangent there, `move` the
 * step and *length its arc length; else the state returns. */
bool km_arc_motion_try(km_arc_motion *follow, double h, double *length);
/* Attempts a step of arc length `length` (either sign) from c.from, to 1e-11, without accepting it. On success the
 * state is at its end, with next_t and `move`; else the state returns. */
bool km_arc_motion_step(km_arc_motion *follow, double length, double *reached);
/* Saves the state's configuration in c.from and computes g there. */
void km_arc_motion_save_start(km_arc_motion *follow);
/* Accepts the attempted step of arc length `length`. */
void km_arc_motion_accept(km_arc_motion *follow, double length);

/* Makes the present configuration the origin of the cycle. */
void km_arc_motion_set_origin(km_arc_motion *follow);
/* True if the attempted step of arc length `length` passes the origin for the first time. */
bool km_arc_motion_passes_origin(km_arc_motion *follow, double length);
/* Moves to the origin by the secant method on the distance along its tangent. If it is met to 1e-9, the step is
 * accepted and the cycle is closed. */
bool km_arc_motion_meet_origin(km_arc_motion *follow, double length);

/* Branch function g = det(pivot block) / t_i with the partition's pivots; and at the end of an attempted step with
 * the pivots of its start (0 right after a branch point, where these are unknown). */
double km_arc_motion_branch_function(const km_arc_motion *follow, const double *t);
double km_arc_motion_branch_function_after_step(km_arc_motion *follow);
/* Locates the branch point within `length` from c.from, where g is g_end at the end: root of the cubic through four
 * values of g, configuration on the curve through them. The state returns to c.from; false if the root is not within
 * the bracket. */
bool km_arc_motion_locate_branch(km_arc_motion *follow, double length, double g_end);

/* Moves the state to the branch point passed last; `tangent` is that of the smooth motion. Then
 * km_arc_motion_take_branch or, on the smooth motion, km_arc_motion_restore. */
void km_arc_motion_move_to_branch_point(km_arc_motion *follow, double *tangent);
/* Continues from the branch point along another direction (scaled step). */
void km_arc_motion_take_branch(km_arc_motion *follow, const double *direction);
/* Starts at a branch point along the direction, of directions[count × columns] (scaled steps), nearest to the one
 * requested in km_arc_motion_create. */
void km_arc_motion_start_branch(km_arc_motion *follow, const double *directions, int count);

#endif
