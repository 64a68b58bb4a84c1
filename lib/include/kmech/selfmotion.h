/* Motions of an arm that leave its effector where it is, and all the ways in which an arm reaches a pose. */
#ifndef KMECH_SELFMOTION_H
#define KMECH_SELFMOTION_H

#include "kmech/path.h"
#include "kmech/progress.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A stretch of a self-motion on which every joint is within its limits, at one combination of full turns. */
typedef struct km_arc_span {
  double from, to; /* arc length; `from` is below 0 where the start of a closed curve is inside. A hinge with room for a
                    * full turn that makes one round a closed curve runs on: then for more rounds, either way */
  int column[2];   /* whose limits end it; -1: the motion itself ends, or nothing does */
} km_arc_span;

/* One component: a curve of poses. Arc length u is Euclidean over the coordinates: radians, slides over L. Full turns
 * of hinges don't count as a difference. */
typedef struct km_selfmotion {
  int count, columns; /* poses; coordinates n of the arm */
  double *u;          /* [count] increasing; 0 at the pose that it was followed from */
  double *q;          /* [count × columns] model's units, base first; continuous */
  bool closed;        /* it comes back to its start, full turns of hinges aside */
  bool turns_on;      /* closed but for full turns of hinges with limits that leave room for them: only limits end it */
  double length;      /* of the closed curve, or from end to end */
  double error;       /* of the effector's pose, the largest along it: lengths over L */
  km_arc_span *arcs;  /* at all full turns that the limits leave room for, by their turns */
  int arc_count;
  int *turn;             /* [arc_count × columns] the full turn in which a hinge with room for several is in the arc's
                          * middle, else 0; NULL with two spare freedoms */
  bool whole;            /* closed, and within the limits all the way */
  int row_count;         /* the arcs' poses, from located end to located end; of a whole curve back to its start */
  int *row_arc;          /* [row_count] which arc */
  double *row_u, *row_q; /* [row_count], [row_count × columns]; limited hinges within their limits, continuous */
  unsigned long evaluations; /* Jacobians that it took */
} km_selfmotion;

enum {
  KM_SELFMOTION_DIRECTIONS = 12 /* looked in with two spare freedoms */
};

/* Follows the self-motion through q[n] (model's units, base first) in both senses: round its closed curve, or until it
 * ends in a singular pose, or its slides leave for infinity. Where limits are crossed is found as roots along the
 * curve. With two spare freedoms: in KM_SELFMOTION_DIRECTIONS directions of a circle, each carried on without turning
 * to a limit or up to π; an arc a direction. Hinges whose limits are a full turn apart or more are delivered at
 * every turn within them, whichever turn q is in (with two spare freedoms at that of q); the others have one angle
 * within their limits. KM_USAGE: none or more than two spare freedoms; KM_MEMORY; KM_CANCELLED. Free `*out` in any
 * case. */
KM_API km_status km_selfmotion_follow(const km_arm *arm, const double *q, km_progress progress, void *context,
                                      km_selfmotion *out, km_error *error);
KM_API void km_selfmotion_free(km_selfmotion *motion);

/* All components of the poses that hold the effector at a pose. */
typedef struct km_ik_solutions {
  int count;             /* components */
  km_selfmotion *items;  /* with one freedom: curves; else single poses (count 1, length 0) */
  double *pose;          /* [count × columns] of each branch: within the limits, as far from them as it gets */
  double *margin;        /* [count] limit distance there; below 0: no pose within the limits */
  bool *singular;        /* [count] found at a singular pose: perhaps one of a family of poses */
  int within;            /* how many have poses within the limits; they come first */
  int starts, converged; /* evidence: starts of Newton's method, and solutions */
  bool closed_form;      /* three neighbouring axes meet or are parallel: the solutions are those of the closed form */
  bool confirmed;        /* the count of components; false: there may be more */
} km_ik_solutions;

/* In closed form where six hinges (of seven one is held, at many angles) have three neighbouring axes that meet or are
 * parallel; else by Newton's method from many starts (the same for the same seed), until the count is confirmed: no new
 * ones in a long row, and, of six hinges, as many of either sense. Each solution that lies on no known curve is
 * followed along its own. KM_NO_RESULT: out of reach; KM_MEMORY; KM_CANCELLED. Free `*out` in any case. */
KM_API km_status km_ik_solutions_find(const km_arm *arm, const km_frame_pose *pose, unsigned long seed,
                                      km_progress progress, void *context, km_ik_solutions *out, km_error *error);
KM_API void km_ik_solutions_free(km_ik_solutions *solutions);

#ifdef __cplusplus
}
#endif
#endif
