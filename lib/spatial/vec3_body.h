/* Vectors of three components for a type T, a double or a vector of doubles; included once for each type. The includer
 * defines T and FN(name). See vec3.h. */

typedef struct FN(vec) {
  T x, y, z;
} FN(vec);

static inline FN(vec) FN(sum)(FN(vec) a, FN(vec) b) {
  return (FN(vec)){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline FN(vec) FN(difference)(FN(vec) a, FN(vec) b) {
  return (FN(vec)){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline FN(vec) FN(scaled)(T s, FN(vec) a) {
  return (FN(vec)){s * a.x, s * a.y, s * a.z};
}
static inline FN(vec) FN(axpy)(T s, FN(vec) a, FN(vec) b) { /* s a + b */
  return (FN(vec)){s * a.x + b.x, s * a.y + b.y, s * a.z + b.z};
}
static inline T FN(dot)(FN(vec) a, FN(vec) b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline FN(vec) FN(cross)(FN(vec) a, FN(vec) b) {
  return (FN(vec)){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* Axis k of a frame's axes[3], and rotation of the two other axes about it; by cases, so that they stay in
 * registers. */
static inline FN(vec) FN(axis)(const FN(vec) * axes, int k) {
  return k == 2 ? axes[2] : k == 1 ? axes[1] : axes[0];
}
static inline void FN(turn_two)(FN(vec) * x, FN(vec) * y, T cosine, T sine) {
  FN(vec) rotated = FN(axpy)(cosine, *x, FN(scaled)(sine, *y));
  *y = FN(axpy)(cosine, *y, FN(scaled)(-sine, *x));
  *x = rotated;
}
static inline void FN(turn_about)(FN(vec) * axes, int k, T cosine, T sine) {
  if (k == 2)
    FN(turn_two)(&axes[0], &axes[1], cosine, sine);
  else if (k == 1)
    FN(turn_two)(&axes[2], &axes[0], cosine, sine);
  else
    FN(turn_two)(&axes[1], &axes[2], cosine, sine);
}
