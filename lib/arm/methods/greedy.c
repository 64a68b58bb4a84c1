/* Greedy method: the path-control column at every step, (318) of the thesis. Its rates are those of the
 * pseudo-inverse, q' = J⁺ξ, computed without one (docs/theory.md 12.3). */
#include "arm/methods/method.h"

km_status km_method_greedy(km_tracking_run *run, km_error *error) {
  static const km_step_choice greedy_choice = {0};
  return km_run_steps(run, &greedy_choice, NULL, NULL, error);
}
