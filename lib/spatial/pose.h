/* Rigid displacements X = (R, p): x_parent = R x_child + p (docs/theory.md 1.2). The 6 × 6 matrices are never formed: a
 * screw is transformed by 24 multiplications and 18 additions. */
#ifndef KM_SPATIAL_POSE_H
#define KM_SPATIAL_POSE_H

#include "spatial/rotation.h"

typedef struct km_pose {
  km_rotation R;
  km_vec3 p;
} km_pose;

static inline km_pose km_pose_identity(void) {
  return (km_pose){km_rotation_identity(), {0, 0, 0}};
}

/* Parent coordinates of a point x of the child frame. */
static inline km_vec3 km_pose_point(const km_pose *a, km_vec3 x) {
  return km_vec3_add(km_rotate(&a->R, x), a->p);
}

/* X_a X_b = (R_a R_b, R_a p_b + p_a). */
static inline km_pose km_pose_product(const km_pose *a, const km_pose *b) {
  return (km_pose){km_rotation_product(&a->R, &b->R), km_pose_point(a, b->p)};
}

/* X⁻¹ = (Rᵀ, −Rᵀ p). */
static inline km_pose km_pose_inverse(const km_pose *a) {
  km_rotation R = km_rotation_inverse(&a->R);
  return (km_pose){R, km_vec3_scale(-1.0, km_rotate(&R, a->p))};
}

#endif
