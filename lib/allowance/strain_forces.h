/* Forces in joints without play, whose stiffness takes up the misfits (docs/theory.md 14.9).
 *
 *   C = Σ_j (F_jᵀ F_j / k_f + M_jᵀ M_j / k_m)      F_j, M_j: force and moment of joint j per self-stress
 *   a = −C⁻¹ Wᵀ Δ                                  least elastic energy for the errors Δ
 *   worst case  : |F_j a| ≤ Σ_k h_k ‖F_j C⁻¹ W_kᵀ‖
 *   statistical : 3 √λ_max(F_j C⁻¹ (Σ W_kᵀW_k h_k²/9) C⁻¹ F_jᵀ) */
#ifndef KM_ALLOWANCE_STRAIN_FORCES_H
#define KM_ALLOWANCE_STRAIN_FORCES_H

#include "allowance/joint_fits.h"

/* Force and moment in a joint. */
typedef struct km_strain_forces {
  double force_worst, force_statistical, moment_worst, moment_statistical;
} km_strain_forces;

/* True if a joint of the model states a stiffness. */
bool km_model_states_stiffness(const km_model *model);
/* Forces in all joints, out[stress->joint_count]; NaN if the stiff joints can't take up all misfits, since C is
 * singular. False without memory. O(joints² · count²). */
bool km_strain_forces_compute(const km_mechanism *mechanism, const km_self_stress *stress,
                              const km_support_terms *terms, km_strain_forces *out);

#endif
