/* Moving a mechanism by hand: a joint or a point of a body is pulled towards a target, the loops stay closed, and all
 * other freedoms move as little as they can. */
#ifndef KMECH_HAND_H
#define KMECH_HAND_H

#include "kmech/mobility.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What keeps a pull from its target. */
typedef enum km_hand_stop {
  KM_HAND_FREE,   /* nothing: it is there, or the next pull goes on */
  KM_HAND_LIMIT,  /* a joint is at its limit */
  KM_HAND_TOGGLE, /* the joint can't move the mechanism any further: its mobility number is 0 here */
  KM_HAND_NEAREST /* no motion brings the point any nearer */
} km_hand_stop;
KM_API const char *km_hand_stop_name(km_hand_stop stop); /* "free", "limit", "toggle", "nearest"; "" */

/* How far a pull came. */
typedef struct km_hand_move {
  km_hand_stop stop; /* what kept it from its target */
  int coordinate;    /* LIMIT: the one at its limit; TOGGLE: the one that is pulled; else -1 */
  bool there;        /* the target is reached: a joint's exactly, a point's to 1e-9 of the characteristic length */
  double left;       /* from here to the target: the coordinate's unit, or the model's length */
} km_hand_move;

/* The point of a body that is held, in the body's frame, and where it is to go, in the inertial frame; model's length
 * unit. `normal` (unit vector; 0: none): distances along it don't count, as when a mouse moves in the plane of a screen. */
typedef struct km_hand_grip {
  int body;                              /* which is held */
  double point[3], target[3], normal[3]; /* of the body; where to; across the plane of the pull */
} km_hand_grip;

/* A hand on an assembled state, which must outlive it and is moved by it. KM_USAGE, KM_MEMORY. The caller frees `*out`. */
typedef struct km_hand km_hand;
KM_API km_status km_hand_create(const km_mechanism *mechanism, km_state *state, km_hand **out, km_error *error);
KM_API void km_hand_free(km_hand *hand);
/* Something else has moved the state: what the hand remembers of its way is forgotten. */
KM_API void km_hand_release(km_hand *hand);

/* Moves a coordinate towards `target` (model's unit) along its branch: at most so far that the way of the whole mechanism,
 * √Σ (D δq)² over its coordinates, is about `most` (radians, lengths over the characteristic length). The coordinate then
 * moves by √m of that, m its mobility number: slowly near a toggle (thesis 11.3, with K = most and f = √m). Infinity: all
 * the way. A component of a rotation vector can be pulled where it lies in no loop. Loops are closed to 1e-12; mobility
 * numbers, null spaces and poses belong to the new pose. KM_USAGE: the coordinate is held; KM_MEMORY.
 * Cost: closing the coordinate's substructure a few times; O(bodies). */
KM_API km_status km_hand_pull_joint(km_hand *hand, int coordinate, double target, double most, km_hand_move *out,
                                    km_error *error);

/* Moves the point towards its target: z = Aᵀ(A Aᵀ + ε)⁻¹ e in the motions that the loops and the limits allow, A the
 * point's velocities over L in the basis D⁻¹Z, e the way that is left over L, ε falling with it; steps that would bend too much, open the
 * loops or lead away are halved, and none leaves its branch. `most` and all else as above. O(substructures that carry the body). */
KM_API km_status km_hand_pull_point(km_hand *hand, const km_hand_grip *grip, double most, km_hand_move *out,
                                    km_error *error);

#ifdef __cplusplus
}
#endif
#endif
