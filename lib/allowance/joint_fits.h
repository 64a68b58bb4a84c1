/* Tolerances and plays of joints as terms of support functions (docs/theory.md 14.9).
 *
 *   h(a) = Σ_j (t_p |f| + t_d |m|) at both frames of joint j       t: tolerance of its place and of its direction
 *   c(a) = Σ_j (c_r |f across the axis| + c_a |f along it| + c_t |m|)    c: radial, axial and angular play
 *
 * f, m: force and moment that joint j carries in the self-stress a. */
#ifndef KM_ALLOWANCE_JOINT_FITS_H
#define KM_ALLOWANCE_JOINT_FITS_H

#include "allowance/self_stress.h"
#include "allowance/support_ratio.h"
#include "kmech/sweep.h"

/* True if a joint of the model states a clearance. */
bool km_model_states_clearance(const km_model *model);
/* Terms of a self-stress; joints that state no fit have that of `defaults`. False without memory. */
bool km_fit_terms_create(const km_mechanism *mechanism, const km_self_stress *stress, const km_fit_defaults *defaults,
                         km_arena *arena, km_support_terms *out);
/* Factor of statistical misfits: all combinations of `count` self-stresses stay within it in 99.73 % of the mechanisms,
 * if each error is normal with a third of its tolerance as standard deviation: a third of √(χ² quantile). */
double km_statistical_factor(int count);

#endif
