/* Forces that act only during a motion: damping, friction, motors, controllers, tyres. */
#ifndef KM_FORCES_MOTION_FORCES_H
#define KM_FORCES_MOTION_FORCES_H

#include "forces/forces.h"

/* Force and moment along the inertial axes. */
typedef double km_user_wrench[6];

typedef struct km_moving_forces {
  int loaded_body_count, damper_count, constant_friction_count, module_count, state_count;
  int *loaded_bodies;               /* bodies with forces; their poses and twists must be set */
  int *dampers, *constant_friction; /* coordinates with damping, constant friction */
  const km_model_module **modules;
  int *first_state_of;    /* [module] index of its first internal state */
  double *internal_state; /* [state_count] internal states: ∫e of a controller, slips of a tyre */
  double *internal_rate;  /* [state_count] rates of the internal states at the last update */
  double *drive_force;    /* [coordinate] joint forces of motors and controllers at the last update */
  /* Modules whose force depends on an acceleration. Their forces are unknowns of the equations of motion: `force` acts,
   * and km_implicit_forces_compute gives the force of the law at the accelerations that result. */
  int implicit_count;
  int *implicit;             /* [implicit_count] indices of these modules */
  double *implicit_force;    /* [implicit_count] force that acts */
  double *implicit_work;     /* [implicit_count² + 4 implicit_count] workspace of the solution, */
  size_t *implicit_places;   /* [implicit_count] */
  bool frictionless;         /* linearisation at rest: friction is omitted, because it has no slope at rest */
  double *reaction_friction; /* [coordinate] friction by reactions, set by an analysis; NULL: none */
  /* Motion that the functions of a program see, and forces that it computes. */
  double *user_q, *user_rate, *user_joint; /* [coordinate] */
  km_frame_motion *user_frames;            /* [user.frame_count] */
  km_user_wrench *user_wrenches;           /* [user.frame_count] */
  bool user_stopped;                       /* the program stopped the run at the last update */
  double dissipation; /* power dissipated by dampers, friction and stops at the last update, ≥ 0 */
  double motor_power; /* power supplied by motors, controllers, loads, and springs that act where they don't measure */
} km_moving_forces;

/* Prepares the forces of motion. KM_MODEL: a tyre or stop that a motion can't use; KM_MEMORY. */
km_status km_forces_prepare_motion(km_forces *forces, km_error *error);

/* Computes all forces except weights at the state's coordinates, rates and time. Poses and twists of the bodies in
 * `loaded_bodies` must be set. Never allocates. O(forces). */
void km_forces_update_moving(const km_mechanism *mechanism, const km_state *state, km_forces *forces);

/* Workspace of the forces of a program; and their part of km_forces_update_moving. */
bool km_user_forces_prepare(km_forces *forces);
void km_user_forces_add(const km_mechanism *mechanism, const km_state *state, km_forces *forces);
/* Motion as the functions of a program see it; poses and twists of its frames' bodies must be set. */
km_motion_sample km_user_sample(const km_mechanism *mechanism, const km_state *state, km_forces *forces);

/* Motion of a frame of a loaded body. */
km_frame_motion km_frame_motion_of(const km_forces *forces, int frame);

/* Part s of the friction that acts at a speed: 1 above the stiction speed, below it x (2 − x), x = speed/stiction
 * speed; with the sign of the speed. */
double km_slip_share(double speed, double stiction);
/* Stiction speed in the model's units: the joint's (NULL: none), else 1/1000 of the characteristic length per
 * second. */
double km_stiction_speed(const km_mechanism *mechanism, const km_joint_friction *friction);

/* Forces of the laws of the implicit modules at the state's accelerations and those of the bodies. */
void km_implicit_forces_compute(const km_mechanism *mechanism, const km_state *state, const km_forces *forces,
                                double *out);

/* Adds the forces of tyre `index` on wheel and road, and computes the rates of its slips. */
void km_tire_apply(const km_mechanism *mechanism, km_forces *forces, int index);

#endif
