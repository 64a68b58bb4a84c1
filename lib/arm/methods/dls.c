/* Damped least squares: rates Jᵀ (J Jᵀ + λ²)⁻¹ ξ with λ² = λ₀² (1 − (σ_min/σ₀)²) where σ_min < σ₀ (Y. Nakamura and
 * H. Hanafusa 1986; docs/theory.md 12.5). Newton's corrector removes the pose error that the damping leaves. */
#include "arm/methods/method.h"

km_status km_method_dls(km_tracking_run *run, km_error *error) {
  const km_step_choice choice = {.damping = run->plan->method.damping, .below = run->plan->method.below};
  return km_run_steps(run, &choice, NULL, NULL, error);
}
