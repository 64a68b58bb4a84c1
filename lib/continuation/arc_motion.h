/* A motion that is being followed. Private to kinematics/. */
#ifndef KM_CONTINUATION_ARC_MOTION_H
#define KM_CONTINUATION_ARC_MOTION_H

#include "continuation/predictor_corrector.h"
#include "kmech/continuation.h"

#define KM_FINEST_ARC 1e-13 /* shorter ways along a motion drown in rounding */

struct km_arc_motion {
  km_arena arena;
  km_continuation c; /* `from` is the pose where the smooth motion has come to */
  int freedom;
  int start_branches; /* motions that meet at the starting pose; 0: it is regular */
  double s, largest;  /* arc length so far; the step that step control allows now */
  double origin_s;    /* arc length of the pose whose return closes the cycle: at a branch point, the first after it */
  double cycle;       /* its length, once it was closed */
  bool closed, origin_waits; /* for that first pose */
  int limit;                 /* the coordinate whose limit ended the motion, -1 */
  double *origin_t, *near_t, *far_t, *branch_t;
  double *origin, *near, *far, *branch_pose; /* saved poses */
  double g;                                  /* see follow.c; at this pose with the course's pivots */
  km_branch_point branch;                    /* passed during the last advance, if `branched` */
  bool branched;
  km_step_watch watch;
  km_step_history aside; /* the course and the saved pose while a visit takes several steps */
  double *aside_pose;
};

static inline const km_substructure *km_arc_motion_sub(const km_arc_motion *follow) {
  return km_continuation_sub(&follow->c);
}

/* Who is told of the motion's steps. */
static inline void km_arc_motion_watch(km_arc_motion *f, km_step_watch watch) {
  f->watch = watch;
}

/* From the saved pose by a step whose length is about h. On success the state stands there, next_t is its tangent, `move`
 * the displacement and *length its arc; else the state is back. */
bool km_arc_motion_try(km_arc_motion *follow, double h, double *length);
/* From the saved pose by an arc of exactly `length` (either sign), without accepting it: on success the state
 * stands there, next_t is its tangent, move the way; else the state is back. */
bool km_arc_motion_step(km_arc_motion *follow, double length, double *reached);
/* The state's configuration becomes the saved one, with its g. */
void km_arc_motion_remember(km_arc_motion *follow);
/* Accepts the step just tried, which is `length` long. */
void km_arc_motion_accept(km_arc_motion *follow, double length);

/* The pose that the cycle has to come back to is this one. */
void km_arc_motion_set_origin(km_arc_motion *follow);
/* Does the step just tried, `length` long, pass it for the first time? */
bool km_arc_motion_passes_origin(km_arc_motion *follow, double length);
/* Goes to where it must be, by the secant method on the distance along its tangent; accepts that step and closes the
 * cycle if it is there. */
bool km_arc_motion_meet_origin(km_arc_motion *follow, double length);

/* g = det(pivot block) / t_i with the partition's pivots; and, at the pose just stepped to, with those of the saved pose
 * (0 just after a turn, where there are none). */
double km_arc_motion_g(const km_arc_motion *follow, const double *t);
double km_arc_motion_saved_g(km_arc_motion *follow);
/* A branch point lies between the saved pose and the pose `length` further, where g is g_end: locates it by the cubic
 * through g on either side, and interpolates its pose. Leaves the state at the saved one; false if it escapes. */
bool km_arc_motion_locate_branch(km_arc_motion *follow, double length, double g_end);

/* Puts the state at the branch point that was passed last; `tangent` is that of the smooth motion there. Then
 * km_arc_motion_take_branch or km_arc_motion_continue. */
void km_arc_motion_move_to_branch_point(km_arc_motion *follow, double *tangent);
/* Puts the state back to where the smooth motion has come to. */
void km_arc_motion_continue(km_arc_motion *follow);
/* Continues from the branch point along another direction (scaled step). */
void km_arc_motion_take_branch(km_arc_motion *follow, const double *direction);
/* The pose of km_arc_motion_create is a branch point: starts along that one of the motions that meet there,
 * directions[count × columns] (scaled steps), which is nearest to the direction that was asked for. */
void km_arc_motion_start_branch(km_arc_motion *follow, const double *directions, int count);

#endif
