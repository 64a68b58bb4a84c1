/* Method `fixed`: as many joints are fixed as there are spare freedoms (Uicker). They are named, or they are those
 * that complete pivoting leaves independent at the start. */
#include "arm/methods/method.h"

km_status km_method_fixed(km_tracking_run *run, km_error *error) {
  static const double none[KM_ARM_ROWS] = {0};
  const km_arm *a = run->arm;
  const km_method *method = &run->plan->method;
  for (int i = 0; i < method->joint_count; ++i)
    run->fixed[method->joints[i]] = true;
  if (method->joint_count == 0) {
    km_arm_update(a, &run->space.arm, run->start);
    km_control_pivot(a, &run->space.arm, none, NULL);
    const km_factor *p = run->space.arm.factor;
    for (int c = km_factor_rank(p); c <= a->n;
         ++c) /* the path column is one of the independent columns, but no joint */
      if (km_factor_column_order(p)[c] < a->n)
        run->fixed[km_factor_column_order(p)[c]] = true;
  }
  const km_step_choice choice = {.fixed = run->fixed};
  return km_run_steps(run, &choice, NULL, NULL, error);
}
