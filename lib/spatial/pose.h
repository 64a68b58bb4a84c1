/* Rigid displacements X = (R, p): x_parent = R x_child + p (docs/theory.md 1.2). The 6 × 6 matrices are never formed: a
 * screw is transformed by 24 multiplications and 18 additions. */
#ifndef KM_SPATIAL_POSE_H
#define KM_SPATIAL_POSE_H

#include "spatial/rotation.h"

static inline km_pose km_pose_identity(void) {
  return (km_pose){km_rotation_identity(), {0, 0, 0}};
}

#endif
