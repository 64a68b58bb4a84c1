/* Full turns of hinges: bringing angles within limits, and all the turns that limits leave room for. */
#include "redundancy/branches.h"

#include <string.h>

void km_arm_unwind(const km_arm *a, double *q) {
  for (int k = 0; k < a->n; ++k) {
    bool limited = a->high[k] - a->low[k] < (double)INFINITY;
    double middle = limited ? 0.5 * (a->low[k] + a->high[k]) : 0.0;
    if (km_arm_turns(a, k))
      q[k] = middle + km_arm_difference(a, k, middle, q[k]);
  }
}

bool km_arm_turns_once(const km_arm *a, int column) {
  return km_arm_turns(a, column) && a->high[column] - a->low[column] < 2.0 * M_PI - 1e-9;
}

void km_arm_bring_within(const km_arm *a, double *q) {
  double all[KM_ARM_MOST];
  memcpy(all, q, (size_t)a->n * sizeof *q);
  km_arm_unwind(a, all);
  for (int k = 0; k < a->n; ++k)
    if (km_arm_turns_once(a, k))
      q[k] = all[k];
}
