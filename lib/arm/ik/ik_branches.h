/* Configurations that reach a target pose, and the self-motion curves on which they lie (docs/theory.md 12.8 and
 * 12.9). */
#ifndef KM_ARM_IK_IK_BRANCHES_H
#define KM_ARM_IK_IK_BRANCHES_H

#include "arm/path_control.h"
#include "kmech/arm.h"

/* Finds one configuration that reaches the target, by Newton's method from up to `starts` random starts. Hinges are
 * moved to within half a turn of the middle of their limits. False: none found. */
bool km_arm_search(const km_arm *arm, km_arm_space *space, const km_pose *target, int starts, unsigned long seed,
                   double *q);

/* Finds the configuration within the limits that reaches the target and is closest to near[n]: by Newton's method
 * from there, else among all branches. KM_NO_RESULT: out of reach, or never within the limits. */
km_status km_arm_nearest(const km_arm *arm, const km_pose *target, const double *near, unsigned long seed,
                         km_progress progress, void *context, double *q, km_error *error);

/* A curve of configurations whose effector has the pose `target`. Arrays as in km_selfmotion, q in the arm's units. */
typedef struct km_selfmotion_curve {
  const km_arm *arm;
  km_arm_space *space;
  km_pose target;
  const double *sense; /* [n] direction of growing u; NULL: the tangent's largest entry is positive */
  int count, capacity;
  double *u, *q, *t; /* [count], [count × n], [count × n] unit tangents */
  bool closed, failed;
  double length;
  km_progress progress; /* NULL: no progress calls */
  void *context;
  bool cancelled; /* `failed` is then also true */
} km_selfmotion_curve;

/* Follows the self-motion from q forward and, if that doesn't close, also backward. `longest` bounds the arc length
 * in either direction. More than one spare freedom: forward only, along `sense`. False: out of memory or
 * cancelled. */
bool km_selfmotion_curve_follow(km_selfmotion_curve *curve, const double *q, double longest);
void km_selfmotion_curve_free(km_selfmotion_curve *curve);
/* Interpolates at the fraction x between points i and i + 1, projected onto the target pose; t[n] is the tangent
 * there (may be NULL). */
bool km_selfmotion_curve_interpolate(const km_selfmotion_curve *curve, int i, double x, double *q, double *t);
/* True if the curve contains q, full turns not counted. */
bool km_selfmotion_curve_contains(const km_selfmotion_curve *curve, const double *q);

/* Angle by which a hinge advances over one round of a closed curve: a multiple of 2π. */
double km_selfmotion_curve_turn(const km_selfmotion_curve *curve, int column);
/* Configuration at arc length u; on a closed curve u can lie in other rounds, which shift hinges by their full
 * turns. */
bool km_selfmotion_curve_at(const km_selfmotion_curve *curve, double u, double *q);

/* True if a hinge with wide limits makes full turns along a closed curve; then only limits end the motion. */
bool km_selfmotion_curve_continues(const km_selfmotion_curve *curve);

/* Computes the arcs within the limits, with the continuous angles from the start for hinges with wide limits. If
 * such a hinge makes full turns along a closed curve, the arcs extend over all rounds within its limits. NULL and
 * *count −1: out of memory. The caller frees the result. */
km_arc_span *km_selfmotion_curve_arcs(const km_selfmotion_curve *curve, int *count);

/* Arcs within the limits for all combinations of full turns within wide limits. The set of configurations doesn't
 * depend on the start of the curve. */
typedef struct km_lifted_arcs {
  int count;
  km_arc_span *arcs; /* sorted by their turns */
  int *shift;        /* [count × n] full turns between an arc's hinges and the curve's angles */
  int *turn;         /* [count × n] full turn of a hinge with wide limits in the middle of the arc; 0 for others */
} km_lifted_arcs;
/* Computes all lifted arcs. False: out of memory. Free the result in any case. */
bool km_selfmotion_curve_find_lifted_arcs(const km_selfmotion_curve *curve, km_lifted_arcs *out);
void km_lifted_arcs_free(km_lifted_arcs *lifts);

/* Range of full turns by which a hinge can be shifted so that a value between `least` and `most` is within its
 * limits; 0 … 0 for hinges without wide limits on both sides. */
void km_arm_full_turn_range(const km_arm *arm, int column, double min_sine, double most, int *first, int *last);

/* Shifts hinges by full turns, within wide limits, to the values closest to near[n]. */
void km_arm_shift_to_nearest(const km_arm *arm, const double *near, double *q);

/* Writes a curve as a public record. */
km_status km_selfmotion_export(const km_selfmotion_curve *curve, km_selfmotion *out, km_error *error);

/* True if a hinge's limits are less than a full turn apart (by more than 1e-9): at most one of its angles is then
 * within them. */
bool km_arm_has_narrow_limits(const km_arm *arm, int column);
/* Excess of a coordinate over its limits, ≤ 0 within them; for hinges with narrow limits modulo full turns. */
double km_arm_limit_excess(const km_arm *arm, int column, double q);
/* True if a slide exceeds arm->max_travel: two parallel slides can diverge together. */
bool km_arm_slide_diverged(const km_arm *arm, const double *q);
/* Shifts all hinges by full turns to within half a turn of the middle of their limits. */
void km_arm_unwind(const km_arm *arm, double *q);
/* Shifts the hinges with narrow limits as km_arm_unwind; the others are unchanged. */
void km_arm_unwind_narrow(const km_arm *arm, double *q);
/* Difference b − a; for hinges modulo full turns, in −π … π. */
double km_arm_difference(const km_arm *arm, int column, double a, double b);

#endif
