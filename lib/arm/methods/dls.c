/* Damped least squares: rates Jᵀ(JJᵀ + λ²)⁻¹ξ, λ² = λ₀²(1 − (σ_min/σ₀)²) where σ_min < σ₀ (Nakamura and Hanafusa 1986).
 * Newton steps make up for what the damping leaves behind. */
#include "arm/methods/method.h"

km_status km_method_dls(km_entry_range *run, km_error *error) {
  const km_step_choice way = {.damping = run->plan->method.damping, .below = run->plan->method.below};
  return km_run_steps(run, &way, NULL, NULL, error);
}
