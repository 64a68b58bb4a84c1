/* Vectors of three for each kind of number T, a double or a vector of them: included once for each. What the includer defines:
 * T; FN(name). See vec3.h. */

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
