/* Joints whose motion leads an arm out of a singular configuration.
 *
 *   merit(q) = Σ log(σ_i(q) + ε)          σ_i: singular values of the scaled Jacobian
 *   joint k  : that with the greatest merit(q ± step e_k); the next one from there, until σ_min > regular σ_max */
#ifndef KM_ARM_TRACKING_SINGULAR_JOINTS_H
#define KM_ARM_TRACKING_SINGULAR_JOINTS_H

#include "arm/arm.h"

enum { KM_SINGULAR_JOINTS = 3 /* most joints that are named */ };

typedef struct km_singular_joints {
  int count; /* 0: the configuration is regular, or no such joints make it so */
  int joint[KM_SINGULAR_JOINTS];
  double q[KM_ARM_MAX_JOINTS]; /* regular configuration with these joints moved, within the limits */
} km_singular_joints;

/* O(n² evaluations of the singular values). False without memory. */
bool km_singular_joints_find(const km_arm *arm, const double *q, km_singular_joints *out);

#endif
