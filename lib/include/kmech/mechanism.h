/* Mechanisms, states and kinematics: compilation, closing loops, frames, assembly modes, planar motion. */
#ifndef KMECH_MECHANISM_H
#define KMECH_MECHANISM_H

#include "kmech/base.h"
#include "kmech/model.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- A compiled mechanism: immutable, shared by threads. And its per-thread state. */

/* A compiled model. Immutable but for km_mechanism_renumber, shared by threads. */
typedef struct km_mechanism km_mechanism;
/* A pose of a mechanism with its workspace: one thread's. */
typedef struct km_state km_state;

/* A coordinate kept at a value; the joint then counts as rigid in it. In the model's unit. */
typedef struct km_hold {
  int coordinate; /* of the model */
  double value;   /* in the coordinate's unit */
} km_hold;

/* Compiles the model: topology, each loop's own motion space, and the list of operations that kinematics
 * replays. `holds` keep coordinates at values from the start. The model must outlive the mechanism. The
 * caller frees `*out`. Cost: linear in joints plus the lengths of the loops. */
KM_API km_status km_mechanism_compile(const km_model *model, const km_hold *holds, int hold_count, km_mechanism **out,
                                      km_error *error);
KM_API void km_mechanism_free(km_mechanism *mechanism);

/* Takes over the model's numbers after some have changed (kmech/edit.h): dimensions, displacements, limits, ratios. What
 * was held stays held at its value. The bits are those of a new compilation. The mechanism's states stay usable:
 * km_state_restart them. KM_PARTIAL, with the mechanism as it was: a loop's motion space has changed, compile again.
 * No allocation after the first call. Not while another thread uses the mechanism. Cost: as compiling
 * without the topology. */
KM_API km_status km_mechanism_renumber(km_mechanism *mechanism, km_error *error);

/* What rates of lengths are divided by where they are compared with those of angles: the length that the model states;
 * else the greatest distance between the frames of two joints on one moving body; else, where all of these coincide,
 * the greatest distance between two joints in the assembled pose; else one length unit. Of several models that are
 * compared the first one's serves all. In the model's length unit. `source` may be NULL. */
typedef enum km_length_source {
  KM_LENGTH_STATED,       /* the model states it */
  KM_LENGTH_SHARED,       /* another model's (km_model_share_length) */
  KM_LENGTH_LONGEST_LINK, /* between two joints of one body */
  KM_LENGTH_JOINTS,       /* between two joints in the assembled pose */
  KM_LENGTH_UNIT          /* one length unit */
} km_length_source;
KM_API double km_mechanism_characteristic_length(const km_mechanism *mechanism, km_length_source *source);
KM_API const char *km_length_source_name(km_length_source source); /* "stated", "longest link" … */

/* One thread's workspace at the model's initial displacements, not yet assembled. The mechanism must outlive
 * it. Everything that kinematics needs is allocated here, once. The caller frees `*out`. */
KM_API km_status km_state_create(const km_mechanism *mechanism, km_state **out, km_error *error);
KM_API void km_state_free(km_state *state);

/* Puts a state back to the model's initial displacements, not assembled; after km_mechanism_renumber. */
KM_API void km_state_restart(km_state *state);

/* Coordinates in the model's units; angles are continuous, never wrapped. */
KM_API double km_state_coordinate(const km_state *state, int coordinate);
/* All of them: values[coordinate count]. KM_USAGE. */
KM_API km_status km_state_coordinates(const km_mechanism *mechanism, const km_state *state, double *values,
                                      km_error *error);
/* Puts the free coordinates at these values, or one of them; held ones stay. The loops are open then: km_assemble
 * closes them on the branch that is nearest, and poses and mobility must be updated again. KM_USAGE: a value isn't
 * finite, the one coordinate is held. O(coordinates). */
KM_API km_status km_state_set_coordinates(const km_mechanism *mechanism, km_state *state, const double *values,
                                          km_error *error);
KM_API km_status km_state_set_coordinate(const km_mechanism *mechanism, km_state *state, int coordinate, double value,
                                         km_error *error);

/* Each `rate` of coordinates in the model's units per time unit, and accelerations; those of a ball joint are the components
 * of its angular velocity along its parent frame's axes. NaN: there is no such coordinate. A rate that is set is stated: the
 * start of a motion keeps it, and joints without a stated rate follow (km_dynamics_project_rates). */
KM_API double km_state_rate(const km_state *state, int coordinate);
KM_API double km_state_acceleration(const km_state *state, int coordinate);
KM_API km_status km_state_set_rate(const km_mechanism *mechanism, km_state *state, int coordinate, double rate,
                                   km_error *error);
/* Copies coordinates, rates and time `from` one state to another of the same mechanism. KM_USAGE. O(coordinates). */
KM_API km_status km_state_assign(const km_mechanism *mechanism, km_state *to, const km_state *from, km_error *error);
/* Does a full turn of the coordinate bring the mechanism back? True for hinges, not for slides, screws, balls. */
KM_API bool km_coordinate_turns(const km_mechanism *mechanism, int coordinate);
/* The `time` at which the state is, in the model's unit: prescribed motions and motors follow it. KM_USAGE: not finite. */
KM_API double km_state_time(const km_state *state);
KM_API km_status km_state_set_time(const km_mechanism *mechanism, km_state *state, double time, km_error *error);

/* ---- Closing a mechanism's loops and moving it. */

/* Evidence of an assembly. */
typedef struct km_assembly {
  double residual; /* √(eᵀe/6) of the worst loop, lengths over its substructure's size (235) */
  int worst_loop;  /* -1: a coupling, or none */
  int iterations;  /* Newton steps of the slowest substructure */
} km_assembly;

/* Closes every loop from the state's coordinates, which move as little as they can (least |D δq| a step); from
 * a poor start by damped least squares first. Primary equations reach 1e-12 rms, secondary ones the closure
 * tolerance. KM_MODEL names the loop that can't close, its joints, what is left, and, where rounded data is the
 * cause, the closure tolerance that would do. O(iterations · rank² · columns) a substructure. */
KM_API km_status km_assemble(const km_mechanism *mechanism, km_state *state, km_assembly *evidence, km_error *error);

/* Makes a pose that the model names the one that it starts from: its joints have their values exactly where the others
 * can follow; else the first half of them, or a quarter …, while the rest is where the loops close next to its values. To be called before the model is compiled. KM_USAGE:
 * there is no such pose; KM_MEMORY. */
KM_API km_status km_model_apply_pose(km_model *model, int pose, km_error *error);

/* Poses of all bodies in the inertial frame from the state's coordinates. */
KM_API void km_poses_compute(const km_mechanism *mechanism, km_state *state);
/* The `position` of a frame's origin in the inertial frame, model's length unit. After km_poses_compute. */
KM_API void km_frame_position(const km_mechanism *mechanism, const km_state *state, int frame, double position[3]);

/* ---- Where frames are and how they move.
 *
 * Rates are those of all coordinates of the model, in radians and the model's length unit per unit of time, whatever
 * the model's angle unit; twists are (vx vy vz wx wy wz): the velocity of the frame's origin and its body's angular
 * velocity in radians, along the inertial axes. So Jᵀ (force; torque) is a force in each joint, of angles per radian. */

/* Rotation by rows (its columns are the frame's axes), and the origin's position in the model's length unit, both in
 * the inertial frame. */
typedef struct km_frame_pose {
  double R[9], p[3]; /* rotation; position */
} km_frame_pose;

/* The pose at p, turned from the inertial axes by the rotation vector turn[3]: about its direction by its length in
 * radians, right-handed. KM_USAGE: not finite. */
KM_API km_status km_frame_pose_make(const double p[3], const double turn[3], km_frame_pose *out, km_error *error);

/* The pose of a frame of the model. After km_poses_compute. KM_USAGE. O(1). */
KM_API km_status km_frame_place(const km_mechanism *mechanism, const km_state *state, int frame, km_frame_pose *out,
                                km_error *error);

/* The twist of a frame at rates[coordinate], which must be rates that the loops allow: those of km_driver_motion_tangent,
 * km_arc_motion_tangent, km_transfer_rates, or a column of km_motions_basis. After km_poses_compute. KM_USAGE. O(depth). */
KM_API km_status km_frame_twist(const km_mechanism *mechanism, const km_state *state, int frame, const double *rates,
                                double twist[6], km_error *error);

/* J[6 × coordinate count], column-major: the twist per unit rate of each coordinate on the way from the inertial frame
 * to the body along the spanning tree, 0 for all others and for held ones (thesis (33)-(34)). With loops the rates
 * aren't free: the twists that the frame can have are J N, N by km_motions_basis. After km_poses_compute. KM_USAGE.
 * O(coordinates). */
KM_API km_status km_frame_jacobian(const km_mechanism *mechanism, const km_state *state, int frame, double *J,
                                   km_error *error);

/* inverse = Λ⁻¹ = J N (Nᵀ M N)⁻¹ (J N)ᵀ [6 × 6]: the twist per time that a wrench (f; τ) at the frame's origin gives it from rest,
 * beside what else acts (O. Khatib, A unified approach for motion and force control, 1987; N lets the loops keep closed).
 * M has the bodies' masses and the rotors' inertias. In one over mass, over mass × length, over mass × length² of the
 * model; symmetric, singular where the frame can't move. 1/Λ⁻¹_ii is the mass that a push along axis i feels. After
 * km_poses_compute and km_mobility_compute. KM_MODEL: a free motion moves no mass; KM_USAGE; KM_MEMORY.
 * O(bodies · freedom · (depth + freedom)). */
KM_API km_status km_frame_inverse_inertia(const km_mechanism *mechanism, const km_state *state, int frame,
                                          double inverse[36], km_error *error);

/* ---- Assembly modes: the different ways in which loops close for one value of the driver. */

/* The modes that were found, with the evidence of the search. */
typedef struct km_modes {
  int count;           /* different modes within the joint limits; the first is the state's own, wherever that is */
  double *coordinates; /* [count × coordinate count] model's units */
  bool isolated;       /* each stands alone; else something still moves in some of them, which are samples */
  int closed;          /* starting configurations that led to a mode, the state's own included */
  int once;            /* modes that just one of these led to: the more, the more are likely to be missing */
  int outside;         /* further modes, which lie outside the joint limits */
} km_modes;

enum {
  KM_MAX_MODE_STARTS = 1000000 /* the most random starts */
};

/* Fixes `driver` where the state has it (-1, for a structure: nothing, in the largest substructure), starts the other
 * coordinates of its substructure at random places (the same for the same seed), and closes the loops. Two
 * configurations are one mode if the places of the bodies are the same to 1e-6; the turn of a rod about the line
 * between its joints, the halves of struts, and the crosspiece of a universal joint don't count. Struts have lengths
 * of at least 0. The state must be assembled and keeps its configuration. No number of starts shows that all modes are
 * found. KM_USAGE if the driver is held or in no loop, or there is none and something moves; KM_MEMORY; KM_CANCELLED.
 * Free `*out` in any case. O(starts · (closing the loops + modes · bodies)). */
KM_API km_status km_modes_find(const km_mechanism *mechanism, const km_state *state, int driver, int starts,
                               unsigned long seed, km_progress progress, void *context, km_modes *out, km_error *error);
KM_API void km_modes_free(km_modes *modes);

/* ---- Mechanisms that move in parallel planes. */

/* Do all free joints of the mechanism, or of one loop (0 …), turn about one direction and slide across it, at a pose
 * whose poses are updated (km_poses_compute)? Then `normal` is that direction, a unit vector along the inertial axes whose
 * largest component is positive. False too where nothing turns and all slides are parallel. O(joints). */
KM_API bool km_mechanism_plane(const km_mechanism *mechanism, const km_state *state, double normal[3]);
KM_API bool km_loop_plane(const km_mechanism *mechanism, const km_state *state, int loop, double normal[3]);

#ifdef __cplusplus
}
#endif
#endif
