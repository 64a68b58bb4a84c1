/* Kernel of arms with seven single-axis joints and a pose task: forward kinematics, Jacobian, QR factorisation,
 * null vector, minimum-norm solution, singular values.
 *
 *   J^T = Q [R; 0]                 Householder reflections, 7 x 6
 *   null vector = Q e_7
 *   minimum norm: x = Q [R^-T b; 0]  satisfies J x = b;   x = Q [R^-T b; a] has the component a along the null vector
 *
 * The file is included once for each kind of number T: a double, or a vector with one configuration per lane. All
 * lanes do the same operations, nothing is fused and nothing is summed across lanes, so each lane has the bits of
 * the double.
 *
 * The including file defines T; BITS, an unsigned integer of the same size, and NONE, its 0; FN(name), the prefix
 * of all names; km_bits_of(x) and km_number_of(bits); ROOT(x); SIZE(x) = |x|; SIGNED(size, x), a size with the sign
 * of x; MASK, a truth value per lane, with BELOW(a, b), ANY(mask), PICK(mask, a, b). It also defines FN(row), seven
 * numbers in registers:
 *
 *   FN(row_of)(x, step), FN(at)(&row, i), FN(set)(&row, i, x);
 *   FN(from)(&row, c)           the row with zeros before index c;
 *   FN(product)(&a, &b, c)      sum a[i] b[i] of rows with zeros before c; order ((6 + 2) + (4 + 0)) + (3 + (5 + 1));
 *   FN(subtract)(&x, s, &v, c)  x -= s v, v with zeros before index c;
 *   FN(angles), FN(angles_of)(x[SEVEN]), FN(sincos_of)(&angles, j, &sine, &cosine)   of seven angles. */

#include "spatial/vec3_body.h"

typedef struct FN(seven) {
  T jacobian[SEVEN][6]; /* column j: effector's linear, then angular velocity per unit of joint j */
  FN(vec3) axis[SEVEN], point[SEVEN];
  FN(vec3) R[3], p; /* pose of the effector */
  FN(row) v[6];     /* reflection c is I − inverse[c] v vᵀ; v is 0 before index c */
  T inverse[6];
  T gram[6][6];                /* vᵢᵀ vⱼ for i < j */
  T r[6][6], pivot_inverse[6]; /* R by rows; reciprocals of its diagonal */
  T min_pivot, max_pivot;      /* extremes of |diagonal of R| */
  FN(row) null, rates;         /* null vector; minimum-norm rates along the path */
  T path;                      /* path entry z = 1/√(1 + |rates|²) */
} FN(seven);

/* R a for a constant vector a. */
static inline FN(vec3) FN(rotate)(const FN(vec3) * R, km_vec3 a) {
  return (FN(vec3)){a.x * R[0].x + (a.y * R[1].x + a.z * R[2].x), a.x * R[0].y + (a.y * R[1].y + a.z * R[2].y),
                    a.x * R[0].z + (a.y * R[1].z + a.z * R[2].z)};
}

/* Forward kinematics: joint axes and points, pose of the effector, Jacobian (docs/theory.md 12.1). */
static inline void FN(forward)(const km_arm *a, const T *q, FN(seven) * k) {
  FN(vec3) R[3], p;
  T value[SEVEN];
  for (int j = 0; j < SEVEN; ++j)
    value[j] = a->motions[j].sign * q[j];
  const FN(angles) angles = FN(angles_of)(value);
  const km_pose *first = &a->motions[0].before;
  for (int i = 0; i < 3; ++i)
    R[i] = (FN(vec3)){ZERO + first->R.axis[i].x, ZERO + first->R.axis[i].y, ZERO + first->R.axis[i].z};
  p = (FN(vec3)){ZERO + first->p.x, ZERO + first->p.y, ZERO + first->p.z};
  for (int j = 0; j < SEVEN; ++j) {
    const km_arm_motion *m = &a->motions[j];
    if (j > 0) {
      FN(vec3) step = FN(rotate)(R, m->before.p);
      p = (FN(vec3)){p.x + step.x, p.y + step.y, p.z + step.z};
      if (m->has_rotation) {
        FN(vec3) x = FN(rotate)(R, m->before.R.axis[0]), y = FN(rotate)(R, m->before.R.axis[1]);
        R[2] = FN(rotate)(R, m->before.R.axis[2]);
        R[0] = x;
        R[1] = y;
      }
    }
    const FN(vec3) along = FN(vec3_axis)(R, m->axis);
    k->axis[j] = FN(vec3_scale)(ZERO + m->sign, along);
    k->point[j] = p;
    if (m->primitive != KM_REVOLUTE)
      p = FN(vec3_axpy)(m->primitive == KM_PRISMATIC ? value[j] : m->pitch * value[j], along, p);
    if (m->primitive == KM_PRISMATIC)
      continue;
    T sine, cosine;
    FN(sincos_of)(&angles, j, &sine, &cosine);
    FN(vec3_turn_about)(R, m->axis, cosine, sine);
  }
  FN(vec3) tip = FN(rotate)(R, a->tool.p);
  k->p = (FN(vec3)){p.x + tip.x, p.y + tip.y, p.z + tip.z};
  for (int i = 0; i < 3; ++i)
    k->R[i] = FN(rotate)(R, a->tool.R.axis[i]);
  for (int j = 0; j < SEVEN; ++j) {
    const km_arm_motion *m = &a->motions[j];
    FN(vec3) v = k->axis[j], w = {ZERO, ZERO, ZERO};
    if (m->primitive != KM_PRISMATIC) {
      FN(vec3) arm = {k->p.x - k->point[j].x, k->p.y - k->point[j].y, k->p.z - k->point[j].z};
      v = FN(vec3_cross)(k->axis[j], arm);
      w = k->axis[j];
    }
    if (m->primitive == KM_HELICAL)
      v = FN(vec3_axpy)(ZERO + m->pitch, k->axis[j], v);
    T *c = k->jacobian[j];
    c[0] = v.x;
    c[1] = v.y;
    c[2] = v.z;
    c[3] = w.x;
    c[4] = w.y;
    c[5] = w.z;
  }
}

/* Householder reflection c of the columns A of Jᵀ, and row c of R. */
static inline void FN(reflect)(FN(seven) * k, FN(row) * A, int c) {
  const FN(row) row = FN(from)(&A[c], c), tail = FN(from)(&A[c], c + 1);
  T square = FN(product)(&row, &row, c), norm = ROOT(square), head = FN(at)(&A[c], c);
  T inverse = 1.0 / (square + SIZE(head) * norm), first = head + SIGNED(norm, head);
  k->v[c] = tail;
  FN(set)(&k->v[c], c, first);
  k->inverse[c] = inverse;
  k->pivot_inverse[c] = -inverse * first; /* −1/(norm with the sign of head) */
  k->min_pivot = c == 0 ? norm : SMALLER(norm, k->min_pivot);
  k->max_pivot = c == 0 ? norm : LARGER(norm, k->max_pivot);
  UNROLLED
  for (int j = c + 1; j < 6; ++j) {
    T at = FN(at)(&A[j], c), sum = (FN(product)(&tail, &A[j], c + 1) + first * at) * inverse;
    k->r[c][j] = at - sum * first;
    FN(subtract)(&A[j], sum, &tail, c + 1);
  }
}

/* Column c of the Gram matrix of the reflection vectors. */
static inline void FN(set_gram)(FN(seven) * k, int c) {
  UNROLLED
  for (int i = 0; i < c; ++i)
    k->gram[i][c] = FN(product)(&k->v[i], &k->v[c], c);
}

/* Householder QR factorisation of Jᵀ. */
static inline void FN(factor_qr)(FN(seven) * k) {
  FN(row) A[6]; /* columns of Jᵀ */
  UNROLLED
  for (int r = 0; r < 6; ++r)
    A[r] = FN(row_of)(&k->jacobian[0][r], 6);
  UNROLLED
  for (int c = 0; c < 6; ++c)
    FN(reflect)(k, A, c);
  UNROLLED
  for (int c = 1; c < 6; ++c)
    FN(set_gram)(k, c);
}

/* Forward substitution: [R⁻ᵀ b; last] for b[6]. */
static inline FN(row) FN(substitute)(const FN(seven) * k, const T *b, T last) {
  T y[SEVEN];
  UNROLLED
  for (int c = 0; c < 6; ++c) {
    T sum = b[c];
    UNROLLED
    for (int i = 0; i < c; ++i)
      sum -= k->r[i][c] * y[i];
    y[c] = sum * k->pivot_inverse[c];
  }
  y[6] = last;
  return FN(row_of)(y, 1);
}

/* Q x = x − V s, given the products sum[c] = v_cᵀ x. The Gram matrix of the reflection vectors corrects the sums
 * (compact WY form of Schreiber and Van Loan), so the reflections don't depend on intermediate values of x. */
static inline FN(row) FN(apply_q_by_products)(const FN(seven) * k, T *sum, FN(row) x) {
  UNROLLED
  for (int c = 5; c >= 0; --c) {
    sum[c] *= k->inverse[c];
    UNROLLED
    for (int i = 0; i < c; ++i)
      sum[i] -= k->gram[i][c] * sum[c];
  }
  UNROLLED
  for (int c = 5; c >= 0; --c)
    FN(subtract)(&x, sum[c], &k->v[c], c);
  return x;
}

/* Q x by the six reflections. */
static inline FN(row) FN(apply_q)(const FN(seven) * k, FN(row) x) {
  T sum[6];
  UNROLLED
  for (int c = 0; c < 6; ++c)
    sum[c] = FN(product)(&k->v[c], &x, c);
  return FN(apply_q_by_products)(k, sum, x);
}

/* Solution x of J x = b with the component `along` along the null vector; the minimum-norm solution for 0. */
static inline FN(row) FN(solve)(const FN(seven) * k, const T *b, T along) {
  return FN(apply_q)(k, FN(substitute)(k, b, along));
}

/* Null vector Q e₇; requires FN(factor_qr). */
static inline void FN(find_null)(FN(seven) * k) {
  const T last[SEVEN] = {ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO + 1.0};
  T sum[6];
  UNROLLED
  for (int c = 0; c < 6; ++c)
    sum[c] = FN(at)(&k->v[c], 6);
  k->null = FN(apply_q_by_products)(k, sum, FN(row_of)(last, 1));
}

/* QR factorisation, null vector, minimum-norm rates with J rates = b, and path entry 1/√(1 + |rates|²). */
static inline void FN(factor)(FN(seven) * k, const T *b) {
  FN(factor_qr)(k);
  FN(find_null)(k);
  FN(row) y = FN(substitute)(k, b, ZERO);
  k->path = 1.0 / ROOT(1.0 + FN(product)(&y, &y, 0)); /* Q preserves lengths */
  k->rates = FN(apply_q)(k, y);
}

/* Component of x[7] along the null vector. */
static inline T FN(along_null)(const FN(seven) * k, const T *x) {
  FN(row) row = FN(row_of)(x, 1);
  return FN(product)(&k->null, &row, 0);
}

/* Rotation vector from R to the target's axes, in inertial axes, for small angles: s = ½ Σ Rᵢ × targetᵢ has length
 * sin θ, and θ/sin θ is a series. *sine2 = sin²θ and *trace = 1 + 2 cos θ show if the angle is small; the result is
 * invalid otherwise. */
static inline FN(vec3) FN(rotation_error)(const FN(vec3) * R, const FN(vec3) * target, T *sine2, T *write_track) {
  FN(vec3) s = {ZERO, ZERO, ZERO};
  *write_track = ZERO;
  for (int i = 0; i < 3; ++i) {
    FN(vec3) c = FN(vec3_cross)(R[i], target[i]);
    s = (FN(vec3)){s.x + c.x, s.y + c.y, s.z + c.z};
    *write_track += FN(vec3_dot)(R[i], target[i]);
  }
  s = FN(vec3_scale)(ZERO + 0.5, s);
  T x = FN(vec3_dot)(s, s);
  *sine2 = x;
  return FN(vec3_scale)(1.0 + x * (1.0 / 6.0 + x * (3.0 / 40.0 + x * (15.0 / 336.0))), s);
}

/* Path-control column path[8] = (rates, 1)/√(1 + |rates|²). */
static inline void FN(path_column)(const FN(seven) * k, T *path) {
  UNROLLED
  for (int i = 0; i < SEVEN; ++i)
    path[i] = FN(at)(&k->rates, i) * k->path;
  path[SEVEN] = k->path;
}

/* Singular values of the Jacobian, unordered, by one-sided Jacobi rotations: pairs of rows are rotated until all
 * rows are orthogonal; their lengths are then the singular values. Orthogonal pairs are left unchanged, to the bit. */
static inline void FN(singular_values)(const FN(seven) * k, T *sigma) {
  enum { MAX_SWEEPS = 30 };
  T G[6][SEVEN];
  for (int r = 0; r < 6; ++r)
    for (int j = 0; j < SEVEN; ++j)
      G[r][j] = k->jacobian[j][r];
  bool rotated = true;
  for (int sweep = 0; rotated && sweep < MAX_SWEEPS; ++sweep) {
    rotated = false;
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
        rotated = true;
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
