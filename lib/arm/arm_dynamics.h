/* Joint forces of an arm that moves (docs/theory.md 12.10). */
#ifndef KM_ARM_ARM_DYNAMICS_H
#define KM_ARM_ARM_DYNAMICS_H

#include "arm/arm.h"
#include "kinematics/state.h"

/* Computes arm->mass at the state, whose values hold the branches beside the chain rigid. `arcs` is the chain from the
 * base. False: out of memory. */
bool km_arm_set_masses(km_arm *arm, const km_state *state, const km_arc *const *arcs, int count);

/* Joint forces force[n] at q, q̇, q̈ [n] by the recursive Newton-Euler method: inertia, weight, armature and damping of
 * the joints. O(n). */
void km_arm_joint_forces(const km_arm *arm, const double *q, const double *rates, const double *accelerations,
                         double *force);

/* Converts the force of a column to the model's unit: force of a slide, else force · length. */
double km_arm_force_to_units(const km_arm *arm, int column, double force);

#endif
