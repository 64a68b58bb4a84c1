/* Self-stresses of a substructure: the left null vectors of J_6 as forces and moments in its joints (docs/theory.md
 * 14.9).
 *
 *   N          [rows × count] basis of {w: wᵀ J_6 = 0}; N_piv: its rows of the misfit components
 *   W_j a      force and moment that joint j carries under w = N (N_piv)⁻¹ a
 *   a = e_i    wᵀ e is the misfit of component i when all joints but those of the components fit */
#ifndef KM_ALLOWANCE_SELF_STRESS_H
#define KM_ALLOWANCE_SELF_STRESS_H

#include "kinematics/state.h"

/* A redundant constraint: a component of the misfit at the joint that closes a loop. */
typedef struct km_misfit_component {
  int loop;      /* loop of the substructure; loops + index of a coupling */
  int component; /* 0 1 2: along x y z of the closing joint's parent frame; 3 4 5: about them; 0 of a coupling */
} km_misfit_component;

enum { KM_STRESS_ROWS = 9 };

/* Self-stresses at one configuration. */
typedef struct km_self_stress {
  int index; /* substructure */
  int count; /* number of independent self-stresses; 0: none */
  int joint_count;
  const int *joint; /* [joint_count] joints of the substructure's loops */
  /* [joint_count × KM_STRESS_ROWS × count] per unit of each self-stress, in the axes of the joint's parent frame: force
   * across the axis (2), along it (1), moment about the origin of the child's frame (3) and of the parent's (3) */
  double *wrench;
  bool measures; /* self-stress i measures misfit i: N ← N N_piv⁻¹. False where N_piv is nearly singular */
} km_self_stress;

/* Number of self-stresses of a substructure at the state's configuration, whose partition is current. */
int km_self_stress_count(const km_state *state, int substructure);
/* Chooses the components in which misfits are measured: those of Gauss elimination with complete pivoting on N.
 * component[km_self_stress_count]. False without memory. */
bool km_misfit_components_choose(const km_mechanism *mechanism, km_state *state, int substructure,
                                 km_misfit_component *component);
/* Computes the self-stresses at the state's configuration, whose partition and poses are current. False without
 * memory. Cost: that of the left null vectors, and O(members · count). */
bool km_self_stress_compute(const km_mechanism *mechanism, km_state *state, int substructure,
                            const km_misfit_component *component, km_arena *arena, km_self_stress *out);

#endif
