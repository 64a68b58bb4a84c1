/* Mechanisms, states and kinematics: compilation, closing loops, frames, assembly modes, planar motion. */
#ifndef KMECH_MECHANISM_H
#define KMECH_MECHANISM_H

#include "kmech/base.h"
#include "kmech/model.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- A compiled mechanism (immutable, shared by threads) and its state (one per thread). */

/* A compiled model. Immutable except by km_mechanism_renumber; shared by threads. */
typedef struct km_mechanism km_mechanism;
/* A configuration of a mechanism with its workspace; belongs to one thread. */
typedef struct km_state km_state;

/* A coordinate held at a value; the joint is rigid in it (docs/theory.md 4.4). */
typedef struct km_hold {
  int coordinate; /* index of the coordinate in the model */
  double value;   /* in the coordinate's unit */
} km_hold;

/* Compiles the model: topology, motion spaces of the loops, and the list of operations of kinematics (docs/theory.md
 * 2.2-2.5). `holds` keep coordinates at values from the start. The model must outlive the mechanism. The caller frees
 * `*out`. KM_USAGE: a hold is invalid; KM_MEMORY. Cost: linear in joints plus the lengths of the loops. */
KM_API km_status km_mechanism_compile(const km_model *model, const km_hold *holds, int hold_count, km_mechanism **out,
                                      km_error *error);
KM_API void km_mechanism_free(km_mechanism *mechanism);

/* Copies the model's numbers after some have changed (kmech/model.h): dimensions, displacements, limits, ratios. Held
 * coordinates keep their values. The bits are those of a new compilation. States stay usable after km_state_restart.
 * KM_PARTIAL: a loop's motion space has changed, compile again; the mechanism is then unchanged. KM_MEMORY. No
 * allocation after the first call. Not while another thread uses the mechanism. Cost: that of compiling without the
 * topology. */
KM_API km_status km_mechanism_renumber(km_mechanism *mechanism, km_error *error);

/* Source of the characteristic length L, by which lengths are divided where they are compared with angles
 * (docs/theory.md 1.4): the stated length; else the longest link, the greatest distance between the frames of two
 * joints on one moving body; else the greatest distance between two joints of the assembled configuration; else one
 * length unit. Models that are compared share the length of the first one. */
typedef enum km_length_source {
  KM_LENGTH_STATED,       /* the model states it */
  KM_LENGTH_SHARED,       /* the length of another model (km_model_share_length) */
  KM_LENGTH_LONGEST_LINK, /* the longest link */
  KM_LENGTH_JOINTS,       /* the greatest distance of two joints in the assembled configuration */
  KM_LENGTH_UNIT          /* one length unit */
} km_length_source;
/* Returns L in the model's length unit; NaN without a mechanism. `source` may be NULL. */
KM_API double km_mechanism_characteristic_length(const km_mechanism *mechanism, km_length_source *source);
KM_API const char *km_length_source_name(km_length_source source); /* "stated", "longest link" … */

/* Creates a state at the model's initial displacements, not yet assembled. All memory of kinematics is allocated here.
 * The mechanism must outlive it. The caller frees `*out`. KM_USAGE, KM_MEMORY. */
KM_API km_status km_state_create(const km_mechanism *mechanism, km_state **out, km_error *error);
KM_API void km_state_free(km_state *state);

/* Resets a state to the model's initial displacements, rates and time, not assembled. Required after
 * km_mechanism_renumber. */
KM_API void km_state_restart(km_state *state);

/* Coordinate in the model's unit; angles are continuous over full turns. NaN: invalid index. */
KM_API double km_state_coordinate(const km_state *state, int coordinate);
/* Copies all coordinates to values[coordinate count]. KM_USAGE. */
KM_API km_status km_state_coordinates(const km_mechanism *mechanism, const km_state *state, double *values,
                                      km_error *error);
/* Sets the free coordinates, or one of them, to values in the model's units; held ones stay. The loops are open then:
 * km_assemble closes them on the nearest branch, and poses and mobility must be updated again. KM_USAGE: a value is not
 * finite, or the one coordinate is held. O(coordinates). */
KM_API km_status km_state_set_coordinates(const km_mechanism *mechanism, km_state *state, const double *values,
                                          km_error *error);
KM_API km_status km_state_set_coordinate(const km_mechanism *mechanism, km_state *state, int coordinate, double value,
                                         km_error *error);

/* Rates and accelerations of coordinates in the model's units per time unit; those of a ball joint are the components
 * of its angular velocity along its parent frame's axes. NaN: invalid index. A rate that is set is stated: the start of
 * a motion keeps it, and joints without a stated rate follow (km_dynamics_project_rates). KM_USAGE. */
KM_API double km_state_rate(const km_state *state, int coordinate);
KM_API double km_state_acceleration(const km_state *state, int coordinate);
KM_API km_status km_state_set_rate(const km_mechanism *mechanism, km_state *state, int coordinate, double rate,
                                   km_error *error);
/* Copies coordinates, rates and time from one state to another of one mechanism. KM_USAGE. O(coordinates). */
KM_API km_status km_state_assign(const km_mechanism *mechanism, km_state *to, const km_state *from, km_error *error);
/* True if a full turn of the coordinate leaves the configuration unchanged: hinges, but not slides, screws and ball
 * joints. */
KM_API bool km_coordinate_turns(const km_mechanism *mechanism, int coordinate);
/* The `time` of the state in the model's unit, for prescribed motions and motors. KM_USAGE: not finite. */
KM_API double km_state_time(const km_state *state);
KM_API km_status km_state_set_time(const km_mechanism *mechanism, km_state *state, double time, km_error *error);

/* ---- Assembly: closing the loops. */

/* Evidence of an assembly. */
typedef struct km_assembly {
  double residual; /* √(eᵀe/6) of the worst loop, lengths over its substructure's size (235) */
  int worst_loop;  /* index of that loop; −1: a coupling, or none */
  int iterations;  /* Newton steps of the slowest substructure */
} km_assembly;

/* Closes every loop from the state's coordinates by Newton's method with minimum-norm steps |D δq|; from a poor start
 * by Levenberg-Marquardt and displaced starts first (docs/theory.md 4.2, 4.3). Primary rows reach 1e-12 rms, secondary
 * ones the closure tolerance. KM_MODEL names the loop that cannot close, its joints, the remaining gap, and for rounded
 * data a closure tolerance that closes it. KM_USAGE, KM_MEMORY. O(iterations · rank² · columns) per substructure. */
KM_API km_status km_assemble(const km_mechanism *mechanism, km_state *state, km_assembly *evidence, km_error *error);

/* Makes a named pose of the model its start: the named joints have their values exactly if the others can follow; else
 * the first half of them, or a quarter …, while the rest closes from its values. Call it before compiling. KM_USAGE:
 * there is no such pose; KM_MEMORY. */
KM_API km_status km_model_apply_pose(km_model *model, int pose, km_error *error);

/* Computes the poses of all bodies in the inertial frame from the state's coordinates. O(bodies). */
KM_API void km_poses_compute(const km_mechanism *mechanism, km_state *state);
/* The `position` of a frame's origin in the inertial frame, in the model's length unit; NaN: invalid index. After
 * km_poses_compute. */
KM_API void km_frame_position(const km_mechanism *mechanism, const km_state *state, int frame, double position[3]);

/* ---- Kinematics of frames.
 *
 * Rates are those of all coordinates of the model, in radians and the model's length unit per unit of time, for any
 * angle unit of the model. Twists are (vx vy vz wx wy wz): velocity of the frame's origin and angular velocity of its
 * body in radians, along the inertial axes. So Jᵀ (force; torque) is a generalised force in each joint, per radian for
 * angles. */

/* Pose of a frame in the inertial frame: rotation, row-major (its columns are the frame's axes), and position of the
 * origin in the model's length unit. */
typedef struct km_frame_pose {
  double R[9], p[3]; /* rotation; position */
} km_frame_pose;

/* Makes a pose at p that is rotated from the inertial axes by the rotation vector turn[3]: about its direction by its
 * length in radians, right-handed. KM_USAGE: not finite. */
KM_API km_status km_frame_pose_make(const double p[3], const double turn[3], km_frame_pose *out, km_error *error);

/* Pose of a frame of the model. After km_poses_compute. KM_USAGE. O(1). */
KM_API km_status km_frame_place(const km_mechanism *mechanism, const km_state *state, int frame, km_frame_pose *out,
                                km_error *error);

/* The `twist` of a frame at rates[coordinate], which must satisfy the loops: rates of km_driver_motion_tangent,
 * km_arc_motion_tangent, km_transfer_rates, or a column of km_motions_basis. After km_poses_compute. KM_USAGE.
 * O(depth). */
KM_API km_status km_frame_twist(const km_mechanism *mechanism, const km_state *state, int frame, const double *rates,
                                double twist[6], km_error *error);

/* Jacobian J[6 × coordinate count], column-major: twist of the frame per unit rate of each coordinate between the
 * inertial frame and the body along the spanning tree; 0 for all others and for held ones (docs/theory.md 2.1). Rates
 * are not free with loops: the possible twists are J N, N by km_motions_basis. After km_poses_compute. KM_USAGE.
 * O(coordinates). */
KM_API km_status km_frame_jacobian(const km_mechanism *mechanism, const km_state *state, int frame, double *J,
                                   km_error *error);

/* Inverse of the operational-space inertia: inverse = Λ⁻¹ = J N (Nᵀ M N)⁻¹ (J N)ᵀ [6 × 6], the acceleration from rest
 * per unit wrench (f; τ) at the frame's origin, without other forces (O. Khatib 1987; N keeps the loops closed). M
 * contains the masses of bodies and rotors. Units 1/mass, 1/(mass · length), 1/(mass · length²) of the model;
 * symmetric, singular if the frame cannot move. 1/Λ⁻¹_ii is the apparent mass along axis i. After km_poses_compute and
 * km_mobility_compute. KM_MODEL: a free motion moves no mass; KM_USAGE; KM_MEMORY. O(bodies · freedom · (depth +
 * freedom)). */
KM_API km_status km_frame_inverse_inertia(const km_mechanism *mechanism, const km_state *state, int frame,
                                          double inverse[36], km_error *error);

/* ---- Assembly modes: the different configurations that close the loops at one value of the driver (docs/theory.md
 * 4.13). */

/* Assembly modes with the evidence of the search. */
typedef struct km_modes {
  int count;           /* number of modes within the joint limits; the first is that of the state, even outside the
                        * limits */
  double *coordinates; /* [count × coordinate count] coordinates of the modes, model's units */
  bool isolated;       /* every mode is isolated; else some have a mobility above 0 and are samples */
  int closed;          /* number of starts that led to a mode, including the state itself */
  int once;            /* modes that one start led to: many of them indicate that modes are missing */
  int outside;         /* number of further modes outside the joint limits */
} km_modes;

enum {
  KM_MAX_MODE_STARTS = 1000000 /* largest number of random starts */
};

/* Finds assembly modes: fixes `driver` at the state's value (−1, for a structure: nothing, in the largest
 * substructure), starts the other coordinates of its substructure at random values (reproducible by the seed), and
 * closes the loops. Two configurations are one mode if the poses of all bodies agree to 1e-6; the rotation of a rod
 * about the line between its joints, the halves of struts, and the crosspiece of a universal joint do not count. Struts
 * have lengths of at least 0. The state must be assembled and keeps its configuration. Random starts never prove
 * completeness. KM_USAGE: the driver is held or in no loop, or there is none and the mechanism moves; KM_MEMORY;
 * KM_CANCELLED. Free `*out` in any case. O(starts · (closing the loops + modes · bodies)). */
KM_API km_status km_modes_find(const km_mechanism *mechanism, const km_state *state, int driver, int starts,
                               unsigned long seed, km_progress progress, void *context, km_modes *out, km_error *error);
KM_API void km_modes_free(km_modes *modes);

/* ---- Mechanisms that move in parallel planes. */

/* True if all free joints of the mechanism, or of one loop (0 …), rotate about one direction and slide normal to it.
 * `normal` is then that unit direction along the inertial axes, with its largest component positive. False also if
 * nothing rotates and all slides are parallel. After km_poses_compute. O(joints). */
KM_API bool km_mechanism_plane(const km_mechanism *mechanism, const km_state *state, double normal[3]);
KM_API bool km_loop_plane(const km_mechanism *mechanism, const km_state *state, int loop, double normal[3]);

#ifdef __cplusplus
}
#endif
#endif
