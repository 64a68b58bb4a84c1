/* As many joints as there are spare freedoms stay where they are (Uicker): those that complete pivoting leaves
 * independent at the start, or named ones. */
#include "arm/methods/method.h"

km_status km_method_fixed(km_entry_range *run, km_error *error) {
  static const double none[KM_ARM_ROWS] = {0};
  const km_arm *a = run->arm;
  const km_method *method = &run->plan->method;
  for (int i = 0; i < method->joint_count; ++i)
    run->held[method->joints[i]] = true;
  if (method->joint_count == 0) {
    km_arm_update(a, &run->space.arm, run->start);
    km_control_pivot(a, &run->space.arm, none, NULL);
    const km_partition *p = &run->space.arm.partition;
    for (int c = p->rank; c <= a->n; ++c) /* the path's column is one of them, and no joint */
      if (p->column[c] < a->n)
        run->held[p->column[c]] = true;
  }
  const km_step_choice way = {.held = run->held};
  return km_run_steps(run, &way, NULL, NULL, error);
}
