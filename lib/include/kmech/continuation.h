/* Continuation of a motion (theory 4): by a driven coordinate, by arc length, and by manipulation of a joint or a
 * point. */
#ifndef KMECH_CONTINUATION_H
#define KMECH_CONTINUATION_H

#include "kmech/base.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Continuation by one driven coordinate. */

/* Reasons for the end of a motion. */
typedef enum km_stop {
  KM_STOP_NONE,      /* the target was reached */
  KM_STOP_TOGGLE,    /* turning point (dead point) of the driver */
  KM_STOP_LIMIT,     /* a joint is at its limit */
  KM_STOP_MAX_STEPS, /* step limit reached, or angles too large to resolve */
  KM_STOP_UNBOUNDED  /* a slide diverges: the end of the motion lies at infinity */
} km_stop;

/* End of a motion. */
typedef struct km_motion_end {
  km_stop stop;     /* reason */
  double position;  /* value of the driver, model's unit: the target, or the located end (to 1e-9 or better) */
  int substructure; /* KM_STOP_TOGGLE, KM_STOP_UNBOUNDED: the substructure; else -1 */
  int coordinate;   /* KM_STOP_LIMIT: the coordinate at its limit; KM_STOP_UNBOUNDED: the slide; else -1 */
} km_motion_end;

/* A motion of one driver from an assembled configuration, along one branch. */
typedef struct km_driver_motion km_driver_motion;

/* Creates a motion driven by `coordinate` of an assembled state; the state must outlive the motion, which moves it.
 * Limits end the motion unless `ignore_limits`. KM_USAGE: the coordinate is held or a component of a ball joint;
 * KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_driver_motion_create(const km_mechanism *mechanism, km_state *state, int coordinate,
                                         bool ignore_limits, km_driver_motion **out, km_error *error);
KM_API void km_driver_motion_free(km_driver_motion *drive);

/* Moves the driver to `target` (model's unit) exactly. The other coordinates close the loops; with further freedoms
 * they follow the path of least motion (theory 4.7). Step control keeps the branch: the result does not depend on the
 * division of a range into targets (1e-8 with one freedom, 1e-4 with more). If the target is not reached, the motion
 * stops at the located end. The state is closed to 1e-12; mobility numbers of the driven substructure can be stale.
 * Never allocates. */
KM_API km_motion_end km_driver_motion_move_to(km_driver_motion *drive, double target);

/* Computes the rates of all coordinates per unit rate of the driver (radians, model's length): rates[coordinate
 * count]. False at a dead point of the driver. */
KM_API bool km_driver_motion_tangent(km_driver_motion *drive, double *rates);

/* Save the position of the motion; restore it exactly, with the bits of all later steps. */
KM_API void km_driver_motion_save(km_driver_motion *drive);
KM_API void km_driver_motion_restore(km_driver_motion *drive);

/* Returns the number of branch points that the motion has crossed smoothly. */
KM_API int km_driver_motion_crossings(const km_driver_motion *drive);

/* Compiles the model and moves it to a configuration: assembled at the file's initial displacements, then driven
 * along its branch, one coordinate after the other, until all `holds` and `sets` have their values (theory 4.4). Held
 * coordinates are rigid in the resulting mechanism, set ones are free. Limits are ignored. KM_MODEL: the initial
 * displacements do not close; KM_NO_RESULT: a value is not reached (with the located end); KM_DIVERGED: too many
 * steps; KM_USAGE: a rotation vector is held or set in part only. The caller frees both. */
KM_API km_status km_mechanism_compile_at(const km_model *model, const km_hold *holds, int hold_count,
                                         const km_hold *sets, int set_count, km_mechanism **mechanism, km_state **state,
                                         km_error *error);

/* Moves an assembled state along its branch, one coordinate after the other, until every `set` has its value. Held
 * coordinates keep their values. After a failure the state is unchanged. Errors as of km_mechanism_compile_at. */
KM_API km_status km_state_move_to(const km_mechanism *mechanism, km_state *state, const km_hold *sets, int set_count,
                                  km_error *error);

/* ---- Continuation by arc length (theory 4.9): through turning points, around cycles, past branch points. */

/* A motion that is followed by arc length. */
typedef struct km_arc_motion km_arc_motion;

enum {
  KM_MAX_BRANCHES = 16 /* most branches that are searched at one branch point */
};

/* A branch point (bifurcation). */
typedef struct km_branch_point {
  double s;     /* arc length from the start */
  int mobility; /* instantaneous mobility of the substructure there */
  int branches; /* branches that intersect there, including the followed one; 0: not searched, or not found */
} km_branch_point;

/* Creates a motion by arc length of one substructure of an assembled state, which must outlive it and is moved by it.
 * Arc length is Euclidean over the substructure's coordinates: radians, lengths over the characteristic length. The
 * motion starts in the direction in which `coordinate` (-1: the one with the largest mobility number) moves with
 * `sign`. With several freedoms it is the one that moves the others least, transported along the motion by
 * projection. The nearest branch is taken at a branch point. Limits end the motion unless `ignore_limits`. KM_USAGE:
 * the coordinate is held or in no loop; KM_NO_RESULT: nothing moves; KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_arc_motion_create(const km_mechanism *mechanism, km_state *state, int coordinate, double sign,
                                      bool ignore_limits, km_arc_motion **out, km_error *error);
KM_API void km_arc_motion_free(km_arc_motion *follow);
/* Returns the substructure that moves; -1 without one. */
KM_API int km_arc_motion_substructure(const km_arc_motion *follow);
KM_API int km_arc_motion_start_branches(
    const km_arc_motion *follow); /* branches at the starting configuration; 0: it is regular */

/* Advances by `length` > 0, at most 1000 (to 1e-9 of it, but no finer than 1e-13); stops early where the cycle
 * closes, and after a branch point. KM_PARTIAL: a joint is at its limit, or no further step is possible; KM_USAGE:
 * another length. Never allocates. */
KM_API km_status km_arc_motion_advance(km_arc_motion *follow, double length);

KM_API double km_arc_motion_length(const km_arc_motion *follow);       /* arc length so far */
KM_API bool km_arc_motion_closed(const km_arc_motion *follow);         /* the motion returned to its start, to 1e-9 */
KM_API double km_arc_motion_cycle_length(const km_arc_motion *follow); /* arc length of the closed cycle; 0: none */
/* Continues a motion whose cycle is closed; further cycles do not stop it. */
KM_API void km_arc_motion_continue_past_cycle(km_arc_motion *follow);
KM_API int km_arc_motion_limit(const km_arc_motion *follow); /* coordinate whose limit ended the motion, -1 none */
/* Returns the branch point that the last advance passed on the smooth branch; false if there was none. */
KM_API bool km_arc_motion_branch(const km_arc_motion *follow, km_branch_point *out);
/* Moves temporarily by `offset` (up to 0.05 in size) along the motion, until km_arc_motion_restore; rates: direction
 * of motion there. Mobility numbers of the state are stale. False if up to 16 steps do not reach it. */
KM_API bool km_arc_motion_sample(km_arc_motion *follow, double offset, double *rates);
KM_API void km_arc_motion_restore(km_arc_motion *follow);
/* Computes the unit direction of motion: rates of all coordinates per arc length (radians, model's length). */
KM_API void km_arc_motion_tangent(const km_arc_motion *follow, double *rates);

/* ---- Manipulation (theory 4.14): a joint or a point of a body is moved towards a target with closed loops and least
 * motion of all other freedoms. */

/* Reasons for the end of a manipulation. */
typedef enum km_manipulation_stop {
  KM_MANIPULATION_FREE,   /* not obstructed: the target is reached, or the next call continues */
  KM_MANIPULATION_LIMIT,  /* a joint is at its limit */
  KM_MANIPULATION_TOGGLE, /* dead point of the joint: its mobility number is 0 */
  KM_MANIPULATION_NEAREST /* the point is as near to its target as the motions allow */
} km_manipulation_stop;
KM_API const char *km_manipulation_stop_name(km_manipulation_stop stop); /* "free", "limit", "toggle", "nearest"; "" */

/* Result of a manipulation. */
typedef struct km_manipulation_step {
  km_manipulation_stop stop; /* reason */
  int coordinate;            /* LIMIT: the coordinate at its limit; TOGGLE: the manipulated one; else -1 */
  bool is_reached;  /* the target is reached: a joint's exactly, a point's to 1e-9 of the characteristic length */
  double remaining; /* remaining distance to the target: the coordinate's unit, or the model's length */
} km_manipulation_step;

/* The manipulated point of a body, in the body's frame, and its target in the inertial frame; model's length unit.
 * Distances along the unit vector `normal` (0: none) are ignored, as for a mouse in the plane of a screen. */
typedef struct km_manipulation_point {
  int body;                              /* the body */
  double point[3], target[3], normal[3]; /* point of the body; its target; normal of the plane of motion */
} km_manipulation_point;

/* A manipulation of an assembled state, which must outlive it and is moved by it. KM_USAGE, KM_MEMORY. The caller
 * frees `*out`. */
typedef struct km_manipulation km_manipulation;
KM_API km_status km_manipulation_create(const km_mechanism *mechanism, km_state *state, km_manipulation **out,
                                        km_error *error);
KM_API void km_manipulation_free(km_manipulation *manipulation);
/* Clears the history after something else has moved the state. */
KM_API void km_manipulation_release(km_manipulation *manipulation);

/* Moves a coordinate towards `target` (model's unit) along its branch, at most so far that the motion of the whole
 * mechanism, √Σ (D δq)² over its coordinates, is about `most` (radians, lengths over the characteristic length). The
 * coordinate then moves by √m of that, m its mobility number: slowly near a dead point. Infinity: all the way. A
 * component of a rotation vector can be moved if it lies in no loop. Loops are closed to 1e-12; mobility numbers,
 * null spaces and poses are current. KM_USAGE: the coordinate is held; KM_MEMORY. Cost: closing the coordinate's
 * substructure a few times; O(bodies). */
KM_API km_status km_manipulation_pull_joint(km_manipulation *manipulation, int coordinate, double target, double most,
                                            km_manipulation_step *out, km_error *error);

/* Moves the point towards its target by damped least squares: z = Aᵀ(A Aᵀ + ε)⁻¹ e in the motions that the loops and
 * the limits allow, A the point's velocities over L in the basis D⁻¹ Z, e the remaining displacement over L, ε
 * decreasing with it. Steps that are corrected too much, open the loops or increase the distance are halved; none
 * leaves its branch. `most` and all else as above. O(substructures that carry the body). */
KM_API km_status km_manipulation_pull_point(km_manipulation *manipulation, const km_manipulation_point *point,
                                            double most, km_manipulation_step *out, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
