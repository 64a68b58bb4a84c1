/* Closing a mechanism's loops and moving it. */
#ifndef KMECH_KINEMATICS_H
#define KMECH_KINEMATICS_H

#include "kmech/mechanism.h"

#ifdef __cplusplus
extern "C" {
#endif

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
KM_API km_status km_model_take_pose(km_model *model, int pose, km_error *error);

/* Poses of all bodies in the inertial frame from the state's coordinates. */
KM_API void km_poses_update(const km_mechanism *mechanism, km_state *state);
/* The `position` of a frame's origin in the inertial frame, model's length unit. After km_poses_update. */
KM_API void km_frame_position(const km_mechanism *mechanism, const km_state *state, int frame, double position[3]);

#ifdef __cplusplus
}
#endif
#endif
