/* The path-control column at every step, (318): the pseudo-inverse's rates without a pseudo-inverse. */
#include "arm/methods/method.h"

km_status km_method_greedy(km_entry_range *run, km_error *error) {
  static const km_step_choice plain = {0};
  return km_run_steps(run, &plain, NULL, NULL, error);
}
