/* Rotations, unit quaternions and poses for a type T, a double or a vector of doubles; included once for each type
 * after vec3_body.h (docs/theory.md 1.2, 1.6). The includer defines T, FN(name), and
 *
 *   ALL(x), ROOT(x), SINCOS(x, &sine, &cosine)
 *   BELOW(a, limit, x, y)                 x where a is below the double `limit`, else y */

typedef struct FN(rotation) {
  FN(vec3) axis[3]; /* axis[k] = R e_k: column k */
} FN(rotation);
typedef struct FN(quaternion) {
  T w, x, y, z;
} FN(quaternion);
typedef struct FN(pose) {
  FN(rotation) R;
  FN(vec3) p;
} FN(pose);

/* R a. */
static inline FN(vec3) FN(rotate)(const FN(rotation) * r, FN(vec3) a) {
  return FN(vec3_axpy)(a.x, r->axis[0], FN(vec3_axpy)(a.y, r->axis[1], FN(vec3_scale)(a.z, r->axis[2])));
}
static inline FN(rotation) FN(rotation_product)(const FN(rotation) * a, const FN(rotation) * b) {
  return (FN(rotation)){{FN(rotate)(a, b->axis[0]), FN(rotate)(a, b->axis[1]), FN(rotate)(a, b->axis[2])}};
}
static inline FN(rotation) FN(rotation_inverse)(const FN(rotation) * r) {
  const FN(vec3) *a = r->axis;
  return (FN(rotation)){{{a[0].x, a[1].x, a[2].x}, {a[0].y, a[1].y, a[2].y}, {a[0].z, a[1].z, a[2].z}}};
}

/* Parent coordinates of a point x of the child frame. */
static inline FN(vec3) FN(pose_point)(const FN(pose) * a, FN(vec3) x) {
  return FN(vec3_add)(FN(rotate)(&a->R, x), a->p);
}
/* X_a X_b = (R_a R_b, R_a p_b + p_a). */
static inline FN(pose) FN(pose_product)(const FN(pose) * a, const FN(pose) * b) {
  return (FN(pose)){FN(rotation_product)(&a->R, &b->R), FN(pose_point)(a, b->p)};
}
/* X⁻¹ = (Rᵀ, −Rᵀ p). */
static inline FN(pose) FN(pose_inverse)(const FN(pose) * a) {
  FN(rotation) R = FN(rotation_inverse)(&a->R);
  return (FN(pose)){R, FN(vec3_scale)(ALL(-1.0), FN(rotate)(&R, a->p))};
}

static inline FN(quaternion) FN(quaternion_product)(FN(quaternion) a, FN(quaternion) b) {
  return (FN(quaternion)){a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
static inline FN(quaternion) FN(quaternion_conjugate)(FN(quaternion) a) {
  return (FN(quaternion)){a.w, -a.x, -a.y, -a.z};
}
static inline FN(quaternion) FN(quaternion_normalised)(FN(quaternion) a) {
  T s = 1.0 / ROOT(a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z);
  return (FN(quaternion)){s * a.w, s * a.x, s * a.y, s * a.z};
}
/* Unit quaternion exp(v/2) of a rotation vector v. */
static inline FN(quaternion) FN(quaternion_exp)(FN(vec3) v) {
  T angle = ROOT(FN(vec3_dot)(v, v)), sine, cosine;
  SINCOS(0.5 * angle, &sine, &cosine);
  T s = BELOW(angle, KM_EXP_SERIES, 0.5 - angle * angle / 48.0, sine / angle);
  return (FN(quaternion)){cosine, s * v.x, s * v.y, s * v.z};
}
/* Rotation matrix of a unit quaternion. */
static inline FN(rotation) FN(quaternion_rotation)(FN(quaternion) q) {
  T xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  T xy = q.x * q.y, yz = q.y * q.z, zx = q.z * q.x;
  T wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return (FN(rotation)){{{1 - 2 * (yy + zz), 2 * (xy + wz), 2 * (zx - wy)},
                         {2 * (xy - wz), 1 - 2 * (zz + xx), 2 * (yz + wx)},
                         {2 * (zx + wy), 2 * (yz - wx), 1 - 2 * (xx + yy)}}};
}

/* Rate of the rotation vector u for the angular velocity w along fixed axes: u̇ = w − ½ u × w + c u × (u × w),
 * c = 1/θ² − (1 + cos θ)/(2 θ sin θ). */
static inline FN(vec3) FN(rotation_vector_rate)(FN(vec3) u, FN(vec3) w) {
  T angle = ROOT(FN(vec3_dot)(u, u)), square = angle * angle, sine, cosine;
  SINCOS(angle, &sine, &cosine);
  T c = BELOW(angle, KM_ROTATION_RATE_SERIES, 1.0 / 12 + square / 720,
              1.0 / square - (1.0 + cosine) / (2.0 * angle * sine));
  FN(vec3) once = FN(vec3_cross)(u, w), twice = FN(vec3_cross)(u, once);
  return FN(vec3_axpy)(c, twice, FN(vec3_axpy)(ALL(-0.5), once, w));
}
