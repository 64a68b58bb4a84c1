/* Static forces: gravity, loads, springs and contacts of a configuration, static balance, reactions. */
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

/* A wrench on the body of a frame, acting at the frame's origin. */
typedef struct km_load {
  int frame;                  /* index of the model's frame */
  double force[3], torque[3]; /* model's units of force, and of force × length */
  /* true: along the frame's axes, which rotate with the body; false: along the inertial axes */
  bool turning;
  /* factor of a model's load (km_model_load_at), borrowed from the model; NULL: 1 */
  const km_load_scale *scale;
} km_load;

/* The loads of one thread, and their values at the last configuration. */
typedef struct km_forces km_forces;

/* Creates the loads: gravity (model's length/time²; NULL: the model's own), `loads` (copied), the model's force modules
 * of types stiffness and contact, and stops of joints. KM_MODEL: an unusable force law; KM_MEMORY. The caller frees
 * `*out`. */
KM_API km_status km_forces_create(const km_mechanism *mechanism, const double gravity[3], const km_load *loads,
                                  int load_count, km_forces **out, km_error *error);
/* As km_forces_create with the model's own gravity and loads. */
KM_API km_status km_forces_create_own(const km_mechanism *mechanism, km_forces **out, km_error *error);
KM_API void km_forces_free(km_forces *forces);

/* Return the model's own analysis.loads: their number, each as a km_load, and its name (borrowed). */
KM_API int km_model_load_count(const km_model *model);
KM_API km_load km_model_load_at(const km_model *model, int index);
KM_API const char *km_model_load_name(const km_model *model, int index);

/* Computes all loads at the state's configuration at rest: wrenches on the bodies, generalised forces of springs and
 * stops in joints; model's force unit and force × length. Contacts act by the elastic part of their normal force,
 * without friction (theory 9.7). Never allocates. O(bodies + springs + contacts). */
KM_API void km_forces_compute(const km_mechanism *mechanism, const km_state *state, km_forces *forces);

/* Return, after km_forces_compute, the wrench on a body about the inertial origin along the inertial axes (f; τ), and
 * the force of springs and stops in a joint along +q, per radian for an angle. Body 0 is the inertial frame. */
KM_API void km_forces_on_body(const km_forces *forces, int body, double wrench[6]);
KM_API double km_forces_in_joint(const km_forces *forces, int coordinate);

/* ---- Static balance (theory 9): forces of joints and actuators that hold a configuration, and reactions of all
 * joints. */

/* Axes of the reactions. */
typedef enum km_axes {
  KM_AXES_JOINT, /* axes of the child's joint frame */
  KM_AXES_FIXED  /* axes of the inertial frame */
} km_axes;

/* Reaction: the wrench of the parent on the child through a joint, including actuator and springs; moment about the
 * origin of the child's joint frame. */
typedef struct km_reaction {
  double force[3], torque[3]; /* model's units of force, and of force × length */
  bool indeterminate[6];      /* fx fy fz tx ty tz: statically indeterminate; the minimum-norm value is given */
} km_reaction;

/* A contact, or a stop that acts, of a static balance. */
typedef struct km_contact_force {
  const char *name;      /* name of the force module, or label of the stop's coordinate; borrowed */
  int coordinate;        /* coordinate of a stop; -1: a contact */
  double penetration;    /* model's units; negative: a gap */
  double normal;         /* normal force, of a hinge's stop a torque, >= 0 */
  double friction_limit; /* largest friction that the contact can carry, μ N */
} km_contact_force;

/* Workspace of a balance. */
typedef struct km_statics_workspace km_statics_workspace;

enum {
  KM_MAX_DIRECTIONS = 64 /* directions that are stored */
};

/* The static balance of one thread. Forces in the model's units, per radian for angles; rates in radians and the
 * model's length. */
typedef struct km_statics {
  int actuator_count;       /* number of actuators */
  const km_port *actuators; /* joints, or points pushed along a direction */
  double *actuator_forces;  /* [actuator] NaN if they cannot hold their substructure */
  /* [actuator] part that friction of the contacts may take: any force within actuator_forces ± friction holds; NaN if
   * the actuators cannot hold a contact's friction; 0 along a sweep */
  double *friction;
  int contact_count;
  km_contact_force *contacts; /* [contact_count] contacts of the model and stops that act; none along a sweep */
  double *least_norm;         /* [coordinate] minimum-norm joint forces f̄; 0 for held ones */
  bool held;                  /* the actuators balance the loads */
  bool redundant;             /* more actuators than needed: forces of least norm */
  int direction_count;        /* number of independent motions out of the actuators' reach */
  double *directions;     /* [KM_MAX_DIRECTIONS × coordinate] rates of the first of them, the largest scaled one 1 */
  bool *falls;            /* [KM_MAX_DIRECTIONS] a load acts on it: the configuration is not held */
  km_reaction *reactions; /* [joint] */
  km_axes axes;           /* axes of the reactions */
  int degree;             /* degree of static indeterminacy: redundant constraints */
  double gravity[3];      /* gravity of the last balance, length / time² */
  km_statics_workspace *work; /* private */
} km_statics;

/* Creates the balance for `actuators`, actuated coordinates (copied; NULL: every free coordinate). KM_USAGE: an
 * actuator is held or named twice; KM_MEMORY. Free `*out` in any case. */
KM_API km_status km_statics_create(const km_mechanism *mechanism, const int *actuators, int actuator_count,
                                   km_axes axes, km_statics *out, km_error *error);
/* Creates the balance for actuators that are joints or points of bodies pushed along a direction (inertial axes); the
 * force of a point is positive along it. The substructures and tree joints that a point moves are balanced together.
 * Ports are copied; names of points are borrowed. KM_USAGE: also a point that cannot move, or that pushes a single
 * tree joint of another actuator. */
KM_API km_status km_statics_create_for(const km_mechanism *mechanism, const km_port *actuators, int actuator_count,
                                       km_axes axes, km_statics *out, km_error *error);
KM_API void km_statics_free(km_statics *statics);

/* Balances the loads at the state's configuration, whose mobility is current. f̄ = −D Z Zᵀ D⁻¹ τ, τ = Hᵀ C⁻ᵀ g
 * (theory 9.1, 9.2). Actuators: Y_Aᵀ f_A = −Yᵀ τ, Y = D⁻¹ Z, of least |D⁻¹ f_A| if redundant (9.3); all joints as
 * actuators give f̄. Reactions: Jᵀ μ = f + τ for the wrenches μ of the loops' chords; if indeterminate, of least Σ
 * |force|² + |torque / L|² over all joints, L the characteristic length (9.4). They include the actuators' forces if
 * these hold, else f̄. Updates the loads too. O(coordinates · (6 loops + couplings)²) per substructure; allocates
 * only if a configuration has more freedoms than earlier ones. KM_USAGE: the arguments do not belong together, or the
 * mobility is stale: all results are NaN; KM_MEMORY: nothing is held. */
KM_API km_status km_statics_compute(const km_mechanism *mechanism, km_state *state, km_forces *forces,
                                    km_statics *statics);

/* True if a force exceeds the largest force of an actuator's drive, beyond rounding; and that largest force: infinite
 * without a bound, as for a pushed point. */
KM_API bool km_actuator_passes(const km_mechanism *mechanism, const km_port *actuator, double force);
KM_API double km_actuator_most(const km_mechanism *mechanism, const km_port *actuator);
/* Appends the unit of an actuator's force, such as " N" or " N*mm". */
KM_API void km_push_unit(const km_model *model, const km_port *actuator, km_text *out);

#ifdef __cplusplus
}
#endif
#endif
