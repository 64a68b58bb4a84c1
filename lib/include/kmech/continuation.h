/* Continuation of a motion: by a driven coordinate, by arc length, and by pulling a joint or a point. */
#ifndef KMECH_CONTINUATION_H
#define KMECH_CONTINUATION_H

#include "kmech/base.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Moving a mechanism by one driven coordinate. */

/* What ends a motion. */
typedef enum km_stop {
  KM_STOP_NONE,      /* the whole range was reached */
  KM_STOP_TOGGLE,    /* the driver can't move its substructure any further */
  KM_STOP_LIMIT,     /* a joint is at its limit */
  KM_STOP_MAX_STEPS, /* too many steps: a target millions of steps away, or angles whose rounding drowns the motion */
  KM_STOP_UNBOUNDED  /* a slide leaves without bound: the mechanism reaches the end only at infinity */
} km_stop;

/* How far a motion came. */
typedef struct km_motion_end {
  km_stop stop;     /* why it came no further */
  double position;  /* of the driver, model's unit: the target, or the located end (to 1e-9 or better) */
  int substructure; /* KM_STOP_TOGGLE, KM_STOP_UNBOUNDED: that which stops; -1 none */
  int coordinate;   /* KM_STOP_LIMIT: the coordinate at its limit; KM_STOP_UNBOUNDED: the slide; -1 none */
} km_motion_end;

/* A motion of one driver from an assembled pose, along one branch. */
typedef struct km_driver_motion km_driver_motion;

/* Prepares to drive `coordinate` of an assembled state; the state must outlive the drive and is moved by it.
 * Limits end the motion, but with
 * `ignore_limits`. KM_USAGE if the coordinate is held or a component of a ball joint. The caller frees `*out`. */
KM_API km_status km_driver_motion_create(const km_mechanism *mechanism, km_state *state, int coordinate,
                                         bool ignore_limits, km_driver_motion **out, km_error *error);
KM_API void km_driver_motion_free(km_driver_motion *drive);

/* Moves the driver to `target` (model's unit), exactly; the other coordinates close the loops and, where more
 * than one freedom is left, move least. Steps are controlled by the tangent, so that the branch is kept: the
 * result doesn't depend on how a range is cut into targets (with one freedom to 1e-8, with more to 1e-4). Where the
 * target is out of reach, stops at the located end. The state is closed to 1e-12 at return; mobility numbers of the
 * driven substructure may be stale. Never allocates. */
KM_API km_motion_end km_driver_motion_move_to(km_driver_motion *drive, double target);

/* The direction of motion at the present pose: rates of all coordinates per unit rate of the driver, in the
 * engine's units (radians, model's length). rates[coordinate count]. False at a toggle of the driver. */
KM_API bool km_driver_motion_tangent(km_driver_motion *drive, double *rates);

/* Keeps where the drive stands, and brings it back there exactly, as if it had never left. */
KM_API void km_driver_motion_save(km_driver_motion *drive);
KM_API void km_driver_motion_restore(km_driver_motion *drive);

/* How many singular poses (branch points) the drive has passed, on the smooth motion. */
KM_API int km_driver_motion_crossings(const km_driver_motion *drive);

/* Compiles the model and brings it to a pose: assembled at the file's pose, then moved along its branch, one
 * coordinate after the other, until all `holds` and `sets` have their values. Held coordinates stay rigid in
 * the mechanism that comes out, set ones are free again. Limits don't count. KM_MODEL: the file's own pose can't
 * be closed; KM_NO_RESULT: a value can't be reached (with the end that was located); KM_USAGE: a rotation vector
 * is held or set only in part. The caller frees both. */
KM_API km_status km_mechanism_compile_at(const km_model *model, const km_hold *holds, int hold_count,
                                         const km_hold *sets, int set_count, km_mechanism **mechanism, km_state **state,
                                         km_error *error);

/* Moves an assembled state to a pose of its own mechanism in the same way: along its branch, one coordinate after the
 * other, until every `set` has its value. What the mechanism holds stays. The mechanism stays the same, and after a
 * failure the state does too. KM_NO_RESULT, KM_USAGE as above. */
KM_API km_status km_state_move_to(const km_mechanism *mechanism, km_state *state, const km_hold *sets, int set_count,
                                  km_error *error);

/* ---- Following a motion by arc length, wherever it leads: through toggles, round cycles, past branch points. */

/* A motion that is being followed. */
typedef struct km_arc_motion km_arc_motion;

enum {
  KM_MAX_BRANCHES = 16 /* motions of one branch point that are looked for: as many are a bound, not their number */
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
KM_API km_status km_arc_motion_create(const km_mechanism *mechanism, km_state *state, int coordinate, double sign,
                                      bool ignore_limits, km_arc_motion **out, km_error *error);
KM_API void km_arc_motion_free(km_arc_motion *follow);
/* The substructure that moves; -1 without one. */
KM_API int km_arc_motion_substructure(const km_arc_motion *follow);
KM_API int km_arc_motion_start_branches(
    const km_arc_motion *follow); /* motions that meet at the starting pose; 0: it is regular */

/* Advances by `length` > 0, at most 1000 (to 1e-9 of it, but no finer than 1e-13), stopping early where the cycle closes,
 * and after a branch point. KM_PARTIAL: a joint is at its limit, or no further step can be found. KM_USAGE: another length.
 * Never allocates. */
KM_API km_status km_arc_motion_advance(km_arc_motion *follow, double length);

KM_API double km_arc_motion_length(const km_arc_motion *follow); /* arc length so far */
KM_API bool km_arc_motion_closed(const km_arc_motion *follow);   /* the start was met again, to 1e-9 */
KM_API double
km_arc_motion_cycle(const km_arc_motion *follow); /* arc length of the cycle that was closed; 0: none was */
/* Lets a motion whose cycle is closed go on; the next rounds don't stop it. */
KM_API void km_arc_motion_pass_cycle(km_arc_motion *follow);
KM_API int km_arc_motion_limit(const km_arc_motion *follow); /* the coordinate whose limit ended the motion, -1 none */
/* The branch point that the last advance passed, on the smooth motion; false if there was none. */
KM_API bool km_arc_motion_branch(const km_arc_motion *follow, km_branch_point *out);
/* Goes a short way (up to 0.05) along from here, or back if offset < 0, until km_arc_motion_restore; rates: the direction of
 * motion there. The state stands there, its mobility numbers are stale. False where up to 16 steps don't lead there. */
KM_API bool km_arc_motion_sample(km_arc_motion *follow, double offset, double *rates);
KM_API void km_arc_motion_restore(km_arc_motion *follow);
/* The unit direction of motion: rates of all coordinates per arc length, engine's units. */
KM_API void km_arc_motion_tangent(const km_arc_motion *follow, double *rates);

/* ---- Moving a mechanism by hand: a joint or a point of a body is pulled towards a target, the loops stay closed, and all
 * other freedoms move as little as they can. */

/* What keeps a pull from its target. */
typedef enum km_manipulation_stop {
  KM_MANIPULATION_FREE,   /* nothing: it is there, or the next pull goes on */
  KM_MANIPULATION_LIMIT,  /* a joint is at its limit */
  KM_MANIPULATION_TOGGLE, /* the joint can't move the mechanism any further: its mobility number is 0 here */
  KM_MANIPULATION_NEAREST /* no motion brings the point any nearer */
} km_manipulation_stop;
KM_API const char *km_manipulation_stop_name(km_manipulation_stop stop); /* "free", "limit", "toggle", "nearest"; "" */

/* How far a pull came. */
typedef struct km_manipulation_step {
  km_manipulation_stop stop; /* what kept it from its target */
  int coordinate;            /* LIMIT: the one at its limit; TOGGLE: the one that is pulled; else -1 */
  bool there;  /* the target is reached: a joint's exactly, a point's to 1e-9 of the characteristic length */
  double left; /* from here to the target: the coordinate's unit, or the model's length */
} km_manipulation_step;

/* The point of a body that is held, in the body's frame, and where it is to go, in the inertial frame; model's length
 * unit. `normal` (unit vector; 0: none): distances along it don't count, as when a mouse moves in the plane of a screen. */
typedef struct km_manipulation_point {
  int body;                              /* which is held */
  double point[3], target[3], normal[3]; /* of the body; where to; across the plane of the pull */
} km_manipulation_point;

/* A hand on an assembled state, which must outlive it and is moved by it. KM_USAGE, KM_MEMORY. The caller frees `*out`. */
typedef struct km_manipulation km_manipulation;
KM_API km_status km_manipulation_create(const km_mechanism *mechanism, km_state *state, km_manipulation **out,
                                        km_error *error);
KM_API void km_manipulation_free(km_manipulation *hand);
/* Something else has moved the state: what the hand remembers of its way is forgotten. */
KM_API void km_manipulation_release(km_manipulation *hand);

/* Moves a coordinate towards `target` (model's unit) along its branch: at most so far that the way of the whole mechanism,
 * √Σ (D δq)² over its coordinates, is about `most` (radians, lengths over the characteristic length). The coordinate then
 * moves by √m of that, m its mobility number: slowly near a toggle (thesis 11.3, with K = most and f = √m). Infinity: all
 * the way. A component of a rotation vector can be pulled where it lies in no loop. Loops are closed to 1e-12; mobility
 * numbers, null spaces and poses belong to the new pose. KM_USAGE: the coordinate is held; KM_MEMORY.
 * Cost: closing the coordinate's substructure a few times; O(bodies). */
KM_API km_status km_manipulation_pull_joint(km_manipulation *hand, int coordinate, double target, double most,
                                            km_manipulation_step *out, km_error *error);

/* Moves the point towards its target: z = Aᵀ(A Aᵀ + ε)⁻¹ e in the motions that the loops and the limits allow, A the
 * point's velocities over L in the basis D⁻¹Z, e the way that is left over L, ε falling with it; steps that would bend too much, open the
 * loops or lead away are halved, and none leaves its branch. `most` and all else as above. O(substructures that carry the body). */
KM_API km_status km_manipulation_pull_point(km_manipulation *hand, const km_manipulation_point *grip, double most,
                                            km_manipulation_step *out, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
