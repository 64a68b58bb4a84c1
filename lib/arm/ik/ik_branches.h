/* Poses that reach a target, and the curves they lie on. */
#ifndef KM_ARM_IK_IK_BRANCHES_H
#define KM_ARM_IK_IK_BRANCHES_H

#include "arm/path_control.h"
#include "kmech/arm.h"

/* A pose that reaches the target, from up to `starts` places; false if none is found. Hinges come within a half turn
 * of the middle of their limits. */
bool km_arm_search(const km_arm *arm, km_arm_space *space, const km_pose *target, int starts, unsigned long seed,
                   double *q);

/* The pose nearest to `near`[n] within the limits that reaches the target: by Newton's method from there, else of all
 * branches. KM_NO_RESULT: out of reach, or never within the limits. */
km_status km_arm_nearest(const km_arm *arm, const km_pose *target, const double *near, unsigned long seed,
                         km_progress progress, void *context, double *q, km_error *error);

/* A curve of poses that hold the effector at `target`; arrays as km_selfmotion, but q in the arm's own units. */
typedef struct km_loop_curve {
  const km_arm *arm;
  km_arm_space *space;
  km_pose target;
  const double *sense; /* [n] along which u grows; NULL: the tangent's largest entry is positive */
  int count, capacity;
  double *u, *q, *t; /* [count], [count × n], [count × n] unit tangents */
  bool closed, failed;
  double length;
  km_progress progress; /* NULL: nobody asks */
  void *context;
  bool cancelled; /* then the curve has failed too */
} km_loop_curve;

/* From q along its self-motion: forward, and, if that doesn't close, back from q too. `longest` bounds the way in
 * either sense. With more than one spare freedom forward only, along `sense`. False when out of memory. */
bool km_loop_curve_follow(km_loop_curve *curve, const double *q, double longest);
void km_loop_curve_free(km_loop_curve *curve);
/* The pose a fraction x of the way from point i to i + 1, on the manifold; t[n] its tangent (may be NULL). */
bool km_loop_curve_between(const km_loop_curve *curve, int i, double x, double *q, double *t);
/* Does the curve pass through q (but for full turns)? */
bool km_loop_curve_passes(const km_loop_curve *curve, const double *q);

/* By how much a hinge has turned once round a closed curve: full turns, in radians. */
double km_loop_curve_turn(const km_loop_curve *curve, int column);
/* The pose at u; on a closed curve also rounds before its start and after its end, hinges turning on. */
bool km_loop_curve_at(const km_loop_curve *curve, double u, double *q);

/* Does a hinge that has room for it turn over a closed curve? Only limits then end the motion. */
bool km_loop_curve_runs_on(const km_loop_curve *curve);

/* The stretches within the limits, of hinges that have room for a full turn those of the angles as they come from the
 * start. If such a hinge turns over a closed curve, they run on for as many rounds as its limits leave. NULL and *count
 * −1 when out of memory; the caller frees them. */
km_arc_span *km_loop_curve_arcs(const km_loop_curve *curve, int *count);

/* The stretches within the limits at all full turns that the limits leave room for: the same set of poses from
 * whichever of them the curve was followed. */
typedef struct km_lifts {
  int count;
  km_arc_span *arcs; /* by their turns */
  int *shift;        /* [count × n] full turns that an arc's hinges are ahead of the curve's angles */
  int *turn; /* [count × n] the full turn in which a hinge with room for several is in the arc's middle, else 0 */
} km_lifts;
/* False when out of memory. Free it in any case. */
bool km_loop_curve_lifts(const km_loop_curve *curve, km_lifts *out);
void km_lifts_free(km_lifts *lifts);

/* The first and last number of full turns that a hinge may turn on from anywhere in least … most to meet its limits; 0
 * for hinges that have one angle within them, and those without limits on either side. */
void km_arm_turn_range(const km_arm *arm, int column, double least, double most, int *first, int *last);

/* Turns hinges by full turns that their limits leave room for, to as near to `near`[n] as can be. */
void km_arm_turn_toward(const km_arm *arm, const double *near, double *q);

/* The curve as the public record. */
km_status km_selfmotion_export(const km_loop_curve *curve, km_selfmotion *out, km_error *error);

/* Has a hinge limits with less than a full turn (by 1e-9 and more) between them? At most one of its angles is then
 * within them. */
bool km_arm_turns_once(const km_arm *arm, int column);
/* How far a coordinate is beyond its limits: ≤ 0 within. Of hinges that turn once but for full turns. */
double km_arm_beyond(const km_arm *arm, int column, double q);
/* Has a slide left for infinity? Two parallel slides can diverge together. */
bool km_arm_slides_away(const km_arm *arm, const double *q);
/* Brings hinges by full turns to within a half turn of the middle of their limits. */
void km_arm_unwind(const km_arm *arm, double *q);
/* The same for the hinges that turn once only; the others stay as they are. */
void km_arm_bring_within(const km_arm *arm, double *q);
/* b − a, hinges but for full turns. */
double km_arm_difference(const km_arm *arm, int column, double a, double b);

#endif
