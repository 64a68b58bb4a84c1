/* Following a motion by arc length, wherever it leads: through toggles, round cycles, past branch points. */
#ifndef KMECH_FOLLOW_H
#define KMECH_FOLLOW_H

#include "kmech/kinematics.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A motion that is being followed. */
typedef struct km_follow km_follow;

enum {
  KM_MOST_BRANCHES = 16 /* motions of one branch point that are looked for: as many are a bound, not their number */
};

/* Where several motions meet. */
typedef struct km_branch_point {
  double s;     /* arc length from the start */
  int mobility; /* of the substructure at the pose */
  int branches; /* motions that meet there, the followed one among them; 0: not looked for, or not found */
} km_branch_point;

/* Prepares to follow the motion of one substructure of an assembled state, which must outlive it and is moved by
 * it. Arc length is Euclidean over the substructure's coordinates: radians, lengths over the characteristic
 * length. The direction is that in which `coordinate` (-1: the one with the largest mobility number) moves with
 * `sign`; with several freedoms, the direction of that coordinate that moves the others least, carried along
 * without turning. Limits end it, but with `ignore_limits`. At a branch point, along the motion nearest to it. KM_USAGE if the coordinate is held or in no loop;
 * KM_NO_RESULT if nothing moves. The caller frees `*out`. */
KM_API km_status km_follow_create(const km_mechanism *mechanism, km_state *state, int coordinate, double sign,
                                  bool ignore_limits, km_follow **out, km_error *error);
KM_API void km_follow_free(km_follow *follow);
/* The substructure that moves; -1 without one. */
KM_API int km_follow_substructure(const km_follow *follow);
KM_API int
km_follow_start_branches(const km_follow *follow); /* motions that meet at the starting pose; 0: it is regular */

/* Advances by `length` > 0, at most 1000 (to 1e-9 of it, but no finer than 1e-13), stopping early where the cycle closes,
 * and after a branch point. KM_PARTIAL: a joint is at its limit, or no further step can be found. KM_USAGE: another length.
 * Never allocates. */
KM_API km_status km_follow_advance(km_follow *follow, double length);

KM_API double km_follow_length(const km_follow *follow); /* arc length so far */
KM_API bool km_follow_closed(const km_follow *follow);   /* the start was met again, to 1e-9 */
KM_API double km_follow_cycle(const km_follow *follow);  /* arc length of the cycle that was closed; 0: none was */
/* Lets a motion whose cycle is closed go on; the next rounds don't stop it. */
KM_API void km_follow_go_round(km_follow *follow);
KM_API int km_follow_limit(const km_follow *follow); /* the coordinate whose limit ended the motion, -1 none */
/* The branch point that the last advance passed, on the smooth motion; false if there was none. */
KM_API bool km_follow_branch(const km_follow *follow, km_branch_point *out);
/* Goes a short way (up to 0.05) along from here, or back if offset < 0, until km_follow_return; rates: the direction of
 * motion there. The state stands there, its mobility numbers are stale. False where up to 16 steps don't lead there. */
KM_API bool km_follow_visit(km_follow *follow, double offset, double *rates);
KM_API void km_follow_return(km_follow *follow);
/* The unit direction of motion: rates of all coordinates per arc length, engine's units. */
KM_API void km_follow_tangent(const km_follow *follow, double *rates);

#ifdef __cplusplus
}
#endif
#endif
