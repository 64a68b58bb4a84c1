/* The kernel of arms with seven single-axis joints and a whole pose to keep, for one pose or for several side by side:
 * included once for each kind of number T (a double, or a vector of them). Every operation is the same for each lane,
 * nothing is contracted and nothing is summed across lanes: so a lane has the bits of the plain double.
 *
 * What the includer defines: T; BITS, an unsigned integer of the same size, and NONE, 0 of it; FN(name); km_bits_of(x),
 * km_number_of(bits); ROOT(x); SIZE(x), |x|; SIGNED(size, x), a size with the sign of x; MASK, lane by lane whether
 * something holds, BELOW(a, b), ANY(mask), PICK(mask, a, b).
 *
 *   Jᵀ = Q [R; 0] by Householder's reflections (7 × 6). The last column of Q spans J's null space, and
 *   x = Q [R⁻ᵀ b; 0] is the least x with J x = b. */

typedef struct FN(vec) {
  T x, y, z;
} FN(vec);

typedef struct FN(seven) {
  T jacobian[SEVEN][6]; /* by columns */
  FN(vec) axis[SEVEN], point[SEVEN];
  FN(vec) R[3], p;             /* of the effector */
  T v[6][SEVEN], inverse[6];   /* reflections: I − inverse · v vᵀ */
  T r[6][6], pivot_inverse[6]; /* R by rows; 1 over its diagonal */
  T least, largest;            /* of |R's diagonal| */
  T null[SEVEN];
} FN(seven);

static inline T FN(dot)(FN(vec) a, FN(vec) b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline FN(vec) FN(axpy)(T s, FN(vec) a, FN(vec) b) {
  return (FN(vec)){s * a.x + b.x, s * a.y + b.y, s * a.z + b.z};
}
static inline FN(vec) FN(scaled)(T s, FN(vec) a) {
  return (FN(vec)){s * a.x, s * a.y, s * a.z};
}
static inline FN(vec) FN(cross)(FN(vec) a, FN(vec) b) {
  return (FN(vec)){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/* R a of a constant vector. */
static inline FN(vec) FN(turn)(const FN(vec) * R, km_vec3 a) {
  return (FN(vec)){a.x * R[0].x + (a.y * R[1].x + a.z * R[2].x), a.x * R[0].y + (a.y * R[1].y + a.z * R[2].y),
                   a.x * R[0].z + (a.y * R[1].z + a.z * R[2].z)};
}

#include "spatial/sincos_body.h"

/* Axes, places, pose and Jacobian. */
static inline void FN(forward)(const km_arm *a, const T *q, FN(seven) * k) {
  FN(vec) R[3], p;
  const km_pose *first = &a->motions[0].before;
  for (int i = 0; i < 3; ++i)
    R[i] = (FN(vec)){ZERO + first->R.axis[i].x, ZERO + first->R.axis[i].y, ZERO + first->R.axis[i].z};
  p = (FN(vec)){ZERO + first->p.x, ZERO + first->p.y, ZERO + first->p.z};
  for (int j = 0; j < SEVEN; ++j) {
    const km_arm_motion *m = &a->motions[j];
    if (j > 0) {
      FN(vec) step = FN(turn)(R, m->before.p);
      p = (FN(vec)){p.x + step.x, p.y + step.y, p.z + step.z};
      if (m->turned) {
        FN(vec) x = FN(turn)(R, m->before.R.axis[0]), y = FN(turn)(R, m->before.R.axis[1]);
        R[2] = FN(turn)(R, m->before.R.axis[2]);
        R[0] = x;
        R[1] = y;
      }
    }
    T value = m->sign * q[j];
    k->axis[j] = FN(scaled)(ZERO + m->sign, R[m->axis]);
    k->point[j] = p;
    if (m->primitive != KM_REVOLUTE)
      p = FN(axpy)(m->primitive == KM_PRISMATIC ? value : m->pitch * value, R[m->axis], p);
    if (m->primitive == KM_PRISMATIC)
      continue;
    T sine, cosine;
    FN(sincos)(value, &sine, &cosine);
    int x = (m->axis + 1) % 3, y = (m->axis + 2) % 3;
    FN(vec) turned = FN(axpy)(cosine, R[x], FN(scaled)(sine, R[y]));
    R[y] = FN(axpy)(cosine, R[y], FN(scaled)(-sine, R[x]));
    R[x] = turned;
  }
  FN(vec) tip = FN(turn)(R, a->tool.p);
  k->p = (FN(vec)){p.x + tip.x, p.y + tip.y, p.z + tip.z};
  for (int i = 0; i < 3; ++i)
    k->R[i] = FN(turn)(R, a->tool.R.axis[i]);
  for (int j = 0; j < SEVEN; ++j) {
    const km_arm_motion *m = &a->motions[j];
    FN(vec) v = k->axis[j], w = {ZERO, ZERO, ZERO};
    if (m->primitive != KM_PRISMATIC) {
      FN(vec) arm = {k->p.x - k->point[j].x, k->p.y - k->point[j].y, k->p.z - k->point[j].z};
      v = FN(cross)(k->axis[j], arm);
      w = k->axis[j];
    }
    if (m->primitive == KM_HELICAL)
      v = FN(axpy)(ZERO + m->pitch, k->axis[j], v);
    T *c = k->jacobian[j];
    c[0] = v.x;
    c[1] = v.y;
    c[2] = v.z;
    c[3] = w.x;
    c[4] = w.y;
    c[5] = w.z;
  }
}

/* Loops of the factor are short and wait for their sums: unrolled, they keep them in registers. */
#define UNROLLED _Pragma("GCC unroll 8")

/* Σ a[i] b[i] over i ≥ c, in two sums that don't wait for each other. */
static inline T FN(product)(const T *a, const T *b, int c) {
  T sum[2] = {a[6] * b[6], ZERO};
  UNROLLED
  for (int i = 5; i >= c; --i)
    sum[i & 1] += a[i] * b[i];
  return sum[0] + sum[1];
}

/* x = Q [y; last] of y[6]. */
static inline void FN(apply)(const FN(seven) * k, T *x) {
  UNROLLED
  for (int c = 5; c >= 0; --c) {
    T sum = FN(product)(k->v[c], x, c) * k->inverse[c];
    UNROLLED
    for (int i = c; i < SEVEN; ++i)
      x[i] -= sum * k->v[c][i];
  }
}

/* Reflection c of the Jacobian's rows A, and row c of R. */
static inline void FN(reflect)(FN(seven) * k, T A[6][SEVEN], int c) {
  T *v = k->v[c], rest = FN(product)(A[c], A[c], c + 1), head = A[c][c];
  T square = rest + head * head, norm = ROOT(square);
  T diagonal = SIGNED(norm, head);
  v[c] = head + diagonal;
  UNROLLED
  for (int i = c + 1; i < SEVEN; ++i)
    v[i] = A[c][i];
  k->inverse[c] = 1.0 / (square + head * diagonal);
  k->r[c][c] = -diagonal;
  k->pivot_inverse[c] = -k->inverse[c] * v[c]; /* square + head · diagonal = diagonal · v[c] */
  k->least = c == 0 ? norm : SMALLER(norm, k->least);
  k->largest = c == 0 ? norm : LARGER(norm, k->largest);
  UNROLLED
  for (int j = c + 1; j < 6; ++j) {
    T sum = (FN(product)(v, A[j], c + 1) + v[c] * A[j][c]) * k->inverse[c];
    k->r[c][j] = A[j][c] - sum * v[c];
    UNROLLED
    for (int i = c + 1; i < SEVEN; ++i)
      A[j][i] -= sum * v[i];
  }
}

/* Reflections and R of the Jacobian, and its null vector. */
static inline void FN(factor)(FN(seven) * k) {
  T A[6][SEVEN]; /* columns of Jᵀ: rows of J */
  for (int r = 0; r < 6; ++r)
    for (int j = 0; j < SEVEN; ++j)
      A[r][j] = k->jacobian[j][r];
  UNROLLED
  for (int c = 0; c < 6; ++c)
    FN(reflect)(k, A, c);
  for (int i = 0; i < 6; ++i)
    k->null[i] = ZERO;
  k->null[6] = ZERO + 1.0;
  FN(apply)(k, k->null);
}

/* The x with J x = b that is `along` long along the null vector; the least one for 0. */
static inline void FN(solve)(const FN(seven) * k, const T *b, T along, T *x) {
  UNROLLED
  for (int c = 0; c < 6; ++c) {
    T sum = b[c];
    UNROLLED
    for (int i = 0; i < c; ++i)
      sum -= k->r[i][c] * x[i];
    x[c] = sum * k->pivot_inverse[c];
  }
  x[6] = along;
  FN(apply)(k, x);
}

/* How far x goes along the null vector. */
static inline T FN(along_null)(const FN(seven) * k, const T *x) {
  return FN(product)(k->null, x, 0);
}

/* The turn from R to a target's, as a rotation vector in the inertial axes, for small ones: the skew part of the
 * difference is sin θ, and θ/sin θ a series. *sine2 is sin²θ, *trace 1 + 2 cos θ: where they aren't those of a small
 * turn the result is none. */
static inline FN(vec) FN(turn_left)(const FN(vec) * R, const km_rotation *target, T *sine2, T *trace) {
  FN(vec) s = {ZERO, ZERO, ZERO};
  *trace = ZERO;
  for (int i = 0; i < 3; ++i) {
    FN(vec) t = {ZERO + target->axis[i].x, ZERO + target->axis[i].y, ZERO + target->axis[i].z};
    FN(vec) c = FN(cross)(R[i], t);
    s = (FN(vec)){s.x + c.x, s.y + c.y, s.z + c.z};
    *trace += FN(dot)(R[i], t);
  }
  s = FN(scaled)(ZERO + 0.5, s);
  T x = FN(dot)(s, s);
  *sine2 = x;
  return FN(scaled)(1.0 + x * (1.0 / 6.0 + x * (3.0 / 40.0 + x * (15.0 / 336.0))), s);
}

/* (q′, 1)/√(1 + |q′|²) of q′[7], into path[8]. */
static inline void FN(path_column)(const T *rates, T *path) {
  T scale = 1.0 / ROOT(1.0 + FN(product)(rates, rates, 0));
  for (int i = 0; i < SEVEN; ++i)
    path[i] = rates[i] * scale;
  path[SEVEN] = scale;
}

/* Singular values of the Jacobian, in no order: one-sided Jacobi, which turns pairs of rows until all are at right
 * angles; their lengths are then the singular values. A pair at right angles stays as it is, to the bit. */
static inline void FN(singular_values)(const FN(seven) * k, T *sigma) {
  enum { MOST_SWEEPS = 30 };
  T G[6][SEVEN];
  for (int r = 0; r < 6; ++r)
    for (int j = 0; j < SEVEN; ++j)
      G[r][j] = k->jacobian[j][r];
  bool turned = true;
  for (int sweep = 0; turned && sweep < MOST_SWEEPS; ++sweep) {
    turned = false;
    for (int i = 0; i < 5; ++i)
      for (int j = i + 1; j < 6; ++j) {
        T *x = G[i], *y = G[j], xx = x[0] * x[0], yy = y[0] * y[0], xy = x[0] * y[0];
        for (int c = 1; c < SEVEN; ++c) {
          xx += x[c] * x[c];
          yy += y[c] * y[c];
          xy += x[c] * y[c];
        }
        MASK askew = BELOW(xx * yy * 1e-27, xy * xy);
        if (!ANY(askew))
          continue;
        turned = true;
        T zeta = (yy - xx) / (2.0 * xy), size = SIZE(zeta);
        T t = SIGNED(1.0 / (size + ROOT(1.0 + zeta * zeta)), zeta);
        T cosine = 1.0 / ROOT(1.0 + t * t), sine = cosine * t;
        for (int c = 0; c < SEVEN; ++c) {
          T old = x[c];
          x[c] = PICK(askew, cosine * old - sine * y[c], old);
          y[c] = PICK(askew, sine * old + cosine * y[c], y[c]);
        }
      }
  }
  for (int r = 0; r < 6; ++r) {
    T sum = G[r][0] * G[r][0];
    for (int c = 1; c < SEVEN; ++c)
      sum += G[r][c] * G[r][c];
    sigma[r] = ROOT(sum);
  }
}
#undef UNROLLED
