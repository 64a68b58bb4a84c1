/* What acts on a mechanism only while it moves: damping, stops, friction, motors, controllers, tyres. */
#ifndef KM_FORCES_MOTION_FORCES_H
#define KM_FORCES_MOTION_FORCES_H

#include "forces/forces.h"

typedef struct km_moving_forces {
  int touched_count, damper_count, stop_count, rubbing_count, module_count, memory_count;
  int *touched;                   /* bodies that forces act on: their poses and twists must be known */
  int *dampers, *stops, *rubbing; /* coordinates */
  const km_model_module **modules;
  int *memory_of;     /* [module] its first internal state */
  double *memory;     /* [memory_count] internal states: ∫e of a controller, the slips of a tyre */
  double *rate;       /* [memory_count] their rates at the last update */
  double *drive;      /* [coordinate] what motors and controllers gave in joints at the last update */
  bool frictionless;  /* slopes are asked for: friction that stands has none, and is left out */
  double *pressed;    /* [coordinate] friction by what presses, which an analysis sets; NULL: none */
  double dissipation; /* power that dampers, friction and stops took at the last update: positive */
  double motor_power; /* power that motors, controllers, loads, and springs that act where they don't measure gave */
} km_moving_forces;

/* Makes room for what acts in a motion. KM_MEMORY. */
km_status km_forces_follow_motion(km_forces *forces, km_error *error);

/* Every force but weights at the state's coordinates, rates and time: of bodies that `touched` lists, poses and twists
 * are given. Never allocates. O(forces). */
void km_forces_update_moving(const km_mechanism *mechanism, const km_state *state, km_forces *forces);

/* Energy that stops store beside km_springs_energy. */
double km_stops_energy(const km_mechanism *mechanism, const km_state *state, const km_forces *forces);

/* The share of friction that acts at a speed: all of it from the stiction speed on, below it a parabola through 0. */
double km_slip_share(double speed, double stiction);
/* That speed, in the model's units: a joint's own (NULL: none), else a thousandth of the characteristic length per second. */
double km_stiction_speed(const km_mechanism *mechanism, const km_joint_friction *friction);

/* Value of a motor's law at a time. */
double km_motor_force(const km_model_module *module, double time);

/* Tyre `index` of the moving forces: its force on the wheel and the road, and the rates of its slips. */
void km_tire_push(const km_mechanism *mechanism, km_forces *forces, int index);

#endif
