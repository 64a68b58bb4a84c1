/* Vectors of three components for a type T, a double or a vector of doubles; included once for each type. The includer
 * defines T and FN(name). See vec3.h. */

typedef struct FN(vec3) {
  T x, y, z;
} FN(vec3);

static inline FN(vec3) FN(vec3_add)(FN(vec3) a, FN(vec3) b) {
  return (FN(vec3)){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline FN(vec3) FN(vec3_sub)(FN(vec3) a, FN(vec3) b) {
  return (FN(vec3)){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline FN(vec3) FN(vec3_scale)(T s, FN(vec3) a) {
  return (FN(vec3)){s * a.x, s * a.y, s * a.z};
}
static inline FN(vec3) FN(vec3_axpy)(T s, FN(vec3) a, FN(vec3) b) { /* s a + b */
  return (FN(vec3)){s * a.x + b.x, s * a.y + b.y, s * a.z + b.z};
}
static inline T FN(vec3_dot)(FN(vec3) a, FN(vec3) b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline FN(vec3) FN(vec3_cross)(FN(vec3) a, FN(vec3) b) {
  return (FN(vec3)){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* Axis k of a frame's axes[3], and rotation of the two other axes about it; by cases, so that they stay in
 * registers. */
static inline FN(vec3) FN(vec3_axis)(const FN(vec3) * axes, int k) {
  return k == 2 ? axes[2] : k == 1 ? axes[1] : axes[0];
}
static inline void FN(vec3_turn_two)(FN(vec3) * x, FN(vec3) * y, T cosine, T sine) {
  FN(vec3) rotated = FN(vec3_axpy)(cosine, *x, FN(vec3_scale)(sine, *y));
  *y = FN(vec3_axpy)(cosine, *y, FN(vec3_scale)(-sine, *x));
  *x = rotated;
}
static inline void FN(vec3_turn_about)(FN(vec3) * axes, int k, T cosine, T sine) {
  if (k == 2)
    FN(vec3_turn_two)(&axes[0], &axes[1], cosine, sine);
  else if (k == 1)
    FN(vec3_turn_two)(&axes[2], &axes[0], cosine, sine);
  else
    FN(vec3_turn_two)(&axes[1], &axes[2], cosine, sine);
}
