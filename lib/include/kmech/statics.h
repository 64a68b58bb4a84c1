/* Static forces: gravity, loads and springs of a configuration, static balance, reactions. */
#ifndef KMECH_STATICS_H
#define KMECH_STATICS_H

#include "kmech/base.h"
#include "kmech/mechanism.h"
#include "kmech/transfer.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Loads at a configuration: gravity, applied wrenches, springs. */

/* A wrench on the body of a frame, acting at the frame's origin. Force and torque in the model's units. */
typedef struct km_load {
  int frame;                  /* index of the model's frame */
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
KM_API void km_forces_compute(const km_mechanism *mechanism, const km_state *state, km_forces *forces);

/* After km_forces_compute: the applied wrench on a body about the inertial origin, along the inertial axes
 * (f; τ); the force of springs in a joint along +q of a coordinate, of an angle per radian. Body 0 is the inertial
 * frame. */
KM_API void km_forces_on_body(const km_forces *forces, int body, double wrench[6]);
KM_API double km_forces_in_joint(const km_forces *forces, int coordinate);

/* ---- Static balance: what joints and actuators must hold at a pose, and what every joint then carries. */

/* Along which axes reactions are told. */
typedef enum km_axes {
  KM_AXES_JOINT, /* those of the child's joint frame */
  KM_AXES_FIXED  /* those of the inertial frame */
} km_axes;

/* The wrench of parent on child through a joint, actuator and spring parts included: moment about the origin of the
 * child's joint frame, along that frame's axes or the inertial frame's. */
typedef struct km_reaction {
  double force[3], torque[3]; /* model's units of force, and of force × length */
  bool indeterminate[6];      /* fx fy fz tx ty tz: statics alone doesn't determine it; the least-norm one is given */
} km_reaction;

/* The workspace behind a balance. */
typedef struct km_statics_workspace km_statics_workspace;

enum {
  KM_MAX_DIRECTIONS = 64 /* how many are kept */
};

/* The balance of one thread. Forces in the model's units, those of angles per radian; rates in radians and the
 * model's length. */
typedef struct km_statics {
  int actuator_count;       /* of the set */
  const km_port *actuators; /* joints, or points that are pushed along a direction */
  double *actuator_forces;  /* [actuator] NaN where the set can't hold its substructure */
  double *least_norm;       /* [coordinate] f̄; 0 of held ones */
  bool held;                /* the actuators balance the loads */
  bool redundant;           /* the actuators are more than needed: theirs is the least-norm answer */
  int direction_count;      /* independent motions that the actuators have no force against … */
  double *directions;     /* … [KM_MAX_DIRECTIONS × coordinate] the first of them: rates, the largest scaled one 1 */
  bool *falls;            /* [KM_MAX_DIRECTIONS] the loads push in this one: the pose isn't held */
  km_reaction *reactions; /* [joint] */
  km_axes axes;           /* of the reactions */
  int degree;             /* of static indeterminacy: redundant constraints */
  double gravity[3];      /* that the last balance counted, length / time² */
  km_statics_workspace *work; /* of the library */
} km_statics;

/* Prepares for a set of actuators (coordinates, copied; NULL: every free coordinate). KM_USAGE: an actuator is held
 * or named twice; KM_MEMORY. Free `*out` in any case. */
KM_API km_status km_statics_create(const km_mechanism *mechanism, const int *actuators, int actuator_count,
                                   km_axes axes, km_statics *out, km_error *error);
/* The same for actuators that may be points of bodies along a direction (inertial axes), as a hand that pushes: such a
 * force is counted along the direction. What a point moves with, several substructures and joints outside of loops too,
 * is balanced together. Handles are copied; names of points are borrowed. KM_USAGE: also a point that can't move, or that
 * pushes just one joint outside of loops, which another actuator holds. */
KM_API km_status km_statics_create_for(const km_mechanism *mechanism, const km_port *actuators, int actuator_count,
                                       km_axes axes, km_statics *out, km_error *error);
KM_API void km_statics_free(km_statics *statics);

/* Balances the forces at the state's pose, where mobility is up to date (km_mobility_compute or a sweep's row).
 * f̄ = −D Z Zᵀ D⁻¹ τ, τ = Hᵀ C⁻ᵀ g (296). Actuators: Y_Aᵀ f_A = −Yᵀ τ, Y = D⁻¹ Z, of least |D⁻¹ f_A| where they are
 * redundant: all joints as actuators give f̄. Reactions: Jᵀ μ = f + τ for the wrenches μ of the loops' chords; where
 * the structure is indeterminate, of least Σ |force|² + |torque / L|² over all joints, L the characteristic length.
 * With the actuators' forces where they hold the pose, else with f̄. Updates the forces too.
 * O(coordinates · (6 loops + couplings)²) a substructure; allocates only where a pose has more freedoms than those before.
 * KM_USAGE: they don't belong together, or mobility isn't up to date: all is NaN then. KM_MEMORY: nothing is held. */
KM_API km_status km_statics_compute(const km_mechanism *mechanism, km_state *state, km_forces *forces,
                                    km_statics *statics);

/* Is a force more than the drive of an actuator can give, rounding aside? And that most: infinite where it can give any,
 * as a point that is pushed. */
KM_API bool km_actuator_passes(const km_mechanism *mechanism, const km_port *actuator, double force);
KM_API double km_actuator_most(const km_mechanism *mechanism, const km_port *actuator);
/* " N", " N*mm": the unit of an actuator's force. Appended. */
KM_API void km_push_unit(const km_model *model, const km_port *actuator, km_text *out);

#ifdef __cplusplus
}
#endif
#endif
