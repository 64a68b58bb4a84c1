/* Equations of motion: accelerations, energies and driving forces of a mechanism that moves. */
#ifndef KMECH_DYNAMICS_H
#define KMECH_DYNAMICS_H

#include "kmech/forces.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One thread's equations of motion of a mechanism, with all that its model says acts: masses, gravity, loads, springs,
 * dampers, stops, motors, controllers, tyres, prescribed motions. Joints' coefficients of friction act in km_history_run and
 * km_inverse_run alone. */
typedef struct km_dynamics km_dynamics;

/* `forces` (km_forces_create) and the mechanism are borrowed and must outlive it. KM_MEMORY, KM_MODEL: a force or a
 * prescribed motion can't be used. The caller frees `*out`. O(joints + forces). */
KM_API km_status km_dynamics_create(const km_mechanism *mechanism, km_forces *forces, km_dynamics **out,
                                    km_error *error);
KM_API void km_dynamics_free(km_dynamics *dynamics);

/* Drives a coordinate at a constant rate from a value on (the model's units per time unit), as a prescribed motion
 * would, from time 0. Instead of the law that the model may have for it. KM_USAGE: it is held, a component of a ball, or
 * the numbers aren't finite. */
KM_API km_status km_dynamics_prescribe(km_dynamics *dynamics, int coordinate, double value, double rate,
                                       km_error *error);

/* Makes the rates v keep the closed loops: min |D (v - v0)| subject to J v = 0 (D q: theory 4), with prescribed coordinates at
 * their rates and v_k = v0_k for every stated rate, of km_state_set_rate and of the model; the other joints follow. Stated
 * rates that contradict each other are met in least squares, the caller's before the model's. `change` (may be NULL): the
 * length of the stated rates' change, over theirs. The state's loops are closed. KM_MODEL: a prescribed rate breaks a loop;
 * KM_MEMORY. O(n³) a substructure. */
KM_API km_status km_dynamics_project_rates(km_dynamics *dynamics, km_state *state, double *change, km_error *error);

/* The accelerations at the state's pose, rates and time, into the state: M q̈ + Jᵀλ = Q, J q̈ = γ (133), by elimination
 * to independent coordinates within each substructure and from substructure to substructure (187). Dependent
 * coordinates and rates are made to follow the independent ones. KM_MODEL: a free motion moves no mass; KM_DIVERGED:
 * a loop can't be closed from here. Never allocates but where a partition finds more freedom than ever before.
 * O(Σ bodies · freedom² + freedom³) over the substructures, and their partitions. */
KM_API km_status km_dynamics_accelerate(km_dynamics *dynamics, km_state *state, km_error *error);

/* Energies, in force × length, at the state of the last km_dynamics_accelerate: kinetic; of gravity (0 with all centres
 * of mass at the inertial origin) and springs; power that dampers, friction, stops and tyres take; power that motors,
 * controllers, loads and prescribed motions give. */
typedef struct km_energy {
  double kinetic, potential, dissipation, motor_power; /* energies; powers */
} km_energy;
KM_API km_status km_dynamics_energy(km_dynamics *dynamics, km_state *state, km_energy *out, km_error *error);

/* After km_dynamics_accelerate: the force in a prescribed coordinate that its motion takes, along +q, in the model's
 * force unit, of an angle force × length per radian; NaN where the coordinate isn't prescribed. */
KM_API double km_dynamics_driving_force(const km_dynamics *dynamics, const km_state *state, int coordinate);

/* The largest scaled error of a loop that the last km_dynamics_accelerate was given, and how often partitions have been
 * renewed since km_dynamics_create. */
KM_API double km_dynamics_loop_error(const km_dynamics *dynamics);
KM_API int km_dynamics_repartitions(const km_dynamics *dynamics);

/* About how many multiplications a solution of the equations of motion takes once poses, columns and forces are known:
 * by clusters, and if the bordered matrix (133) were dense. After km_dynamics_accelerate. NaN: nothing to tell of. */
typedef struct km_effort {
  double multiplications, dense; /* by clusters; with the dense matrix */
} km_effort;
KM_API km_effort km_dynamics_effort(const km_dynamics *dynamics, const km_state *state);

#ifdef __cplusplus
}
#endif
#endif
