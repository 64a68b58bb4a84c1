/* Choice of the equations of a minimum-norm step (docs/theory.md 3.5). Private to kinematics/. */
#ifndef KM_KINEMATICS_MINIMUM_NORM_STEP_H
#define KM_KINEMATICS_MINIMUM_NORM_STEP_H

#include "kinematics/state.h"

/* Number of null vectors that do not move the driver. */
static inline int km_count_free_motions(const km_partition *p, int driver) {
  return km_partition_freedom(p) - (driver >= 0 && !p->forced_dependent);
}

/* True if the basis vectors are so many that equations in the rows (normal equations, QR) are cheaper. */
static inline bool km_uses_row_equations(const km_partition *p, int count) {
  return p->sparse && (p->rank < count ? p->rank : count) > KM_MANY_VECTORS;
}

#endif
