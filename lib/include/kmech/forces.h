/* What acts on a mechanism at a pose: gravity, loads, springs. */
#ifndef KMECH_FORCES_H
#define KMECH_FORCES_H

#include "kmech/mechanism.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A wrench on the body of a frame, acting at the frame's origin. Force and torque in the model's units. */
typedef struct km_load {
  int frame;                  /* of the model */
  double force[3], torque[3]; /* model's units of force, and of force × length */
  bool turning;               /* along the frame's axes, else along the inertial frame's */
} km_load;

/* The forces of one thread: which act, and their values at the last pose. */
typedef struct km_forces km_forces;

/* Gathers gravity (length/time² of the model; NULL: the model's own), the loads (copied) and the model's force
 * modules of type stiffness. KM_MODEL for a force law that can't be used, KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_forces_create(const km_mechanism *mechanism, const double gravity[3], const km_load *loads,
                                  int load_count, km_forces **out, km_error *error);
KM_API void km_forces_free(km_forces *forces);

/* The model's own analysis.loads: how many, each as a km_load, and its name (borrowed). */
KM_API int km_model_load_count(const km_model *model);
KM_API km_load km_model_load_at(const km_model *model, int index);
KM_API const char *km_model_load_name(const km_model *model, int index);

/* Computes every force at the state's pose: applied wrenches on the bodies, and generalised forces of springs in
 * joints, in the model's force unit and force × length. Never allocates. O(bodies + springs). */
KM_API void km_forces_update(const km_mechanism *mechanism, const km_state *state, km_forces *forces);

/* After km_forces_update: the applied wrench on a body about the inertial origin, along the inertial axes
 * (f; τ); the force of springs in a joint along +q of a coordinate, of an angle per radian. Body 0 is the inertial
 * frame. */
KM_API void km_forces_on_body(const km_forces *forces, int body, double wrench[6]);
KM_API double km_forces_in_joint(const km_forces *forces, int coordinate);

#ifdef __cplusplus
}
#endif
#endif
