/* The kernel of arms with seven single-axis joints and a whole pose to keep, for one pose or for several side by side:
 * included once for each kind of number T (a double, or a vector of them). Every operation is the same for each lane,
 * nothing is contracted and nothing is summed across lanes: so a lane has the bits of the plain double.
 *
 * What the includer defines: T; BITS, an unsigned integer of the same size, and NONE, 0 of it; FN(name); km_bits_of(x),
 * km_number_of(bits); ROOT(x); SIZE(x), |x|; SIGNED(size, x), a size with the sign of x; MASK, lane by lane whether
 * something holds, BELOW(a, b), ANY(mask), PICK(mask, a, b). And seven numbers as a FN(row), in registers as suits them:
 * FN(row_of)(x, step), FN(at)(&row, i), FN(set)(&row, i, x); FN(from)(&row, c), with 0 before place c; and
 * where a and v have 0 before place c: FN(product)(&a, &b, c), Σ a[i] b[i], being the sum of those of even places,
 * (6 + 2) + (4 + 0), and that of the others, 3 + (5 + 1); FN(subtract)(&x, s, &v, c), x −= s v. And the sines and cosines
 * of seven turns: FN(turns), FN(turns_of)(x[SEVEN]), FN(turn_of)(&turns, j, &sine, &cosine).
 *
 *   Jᵀ = Q [R; 0] by Householder's reflections (7 × 6). The last column of Q spans J's null space, and
 *   x = Q [R⁻ᵀ b; 0] is the least x with J x = b. */

#include "spatial/vec3_body.h"

typedef struct FN(seven) {
  T jacobian[SEVEN][6]; /* by columns */
  FN(vec) axis[SEVEN], point[SEVEN];
  FN(vec) R[3], p; /* of the effector */
  FN(row) v[6];    /* reflections: I − inverse · v vᵀ, v from place c on */
  T inverse[6];
  T gram[6][6];                /* vᵢᵀ vⱼ of i < j */
  T r[6][6], pivot_inverse[6]; /* R by rows; 1 over its diagonal */
  T least, largest;            /* of |R's diagonal| */
  FN(row) null, rates;         /* rates: the least ones along the path */
  T path;                      /* entry of the path in the path-control column: 1/√(1 + |rates|²) */
} FN(seven);

/* R a of a constant vector. */
static inline FN(vec) FN(turn)(const FN(vec) * R, km_vec3 a) {
  return (FN(vec)){a.x * R[0].x + (a.y * R[1].x + a.z * R[2].x), a.x * R[0].y + (a.y * R[1].y + a.z * R[2].y),
                   a.x * R[0].z + (a.y * R[1].z + a.z * R[2].z)};
}

/* Axes, places, pose and Jacobian. */
static inline void FN(forward)(const km_arm *a, const T *q, FN(seven) * k) {
  FN(vec) R[3], p;
  T value[SEVEN];
  for (int j = 0; j < SEVEN; ++j)
    value[j] = a->motions[j].sign * q[j];
  const FN(turns) turns = FN(turns_of)(value);
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
    const FN(vec) along = FN(axis)(R, m->axis);
    k->axis[j] = FN(scaled)(ZERO + m->sign, along);
    k->point[j] = p;
    if (m->primitive != KM_REVOLUTE)
      p = FN(axpy)(m->primitive == KM_PRISMATIC ? value[j] : m->pitch * value[j], along, p);
    if (m->primitive == KM_PRISMATIC)
      continue;
    T sine, cosine;
    FN(turn_of)(&turns, j, &sine, &cosine);
    FN(turn_about)(R, m->axis, cosine, sine);
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

/* Reflection c of the Jacobian's rows A, and row c of R. */
static inline void FN(reflect)(FN(seven) * k, FN(row) * A, int c) {
  const FN(row) row = FN(from)(&A[c], c), tail = FN(from)(&A[c], c + 1);
  T square = FN(product)(&row, &row, c), norm = ROOT(square), head = FN(at)(&A[c], c);
  T inverse = 1.0 / (square + SIZE(head) * norm), first = head + SIGNED(norm, head);
  k->v[c] = tail;
  FN(set)(&k->v[c], c, first);
  k->inverse[c] = inverse;
  k->pivot_inverse[c] = -inverse * first; /* 1 over −norm with the sign of head */
  k->least = c == 0 ? norm : SMALLER(norm, k->least);
  k->largest = c == 0 ? norm : LARGER(norm, k->largest);
  UNROLLED
  for (int j = c + 1; j < 6; ++j) {
    T at = FN(at)(&A[j], c), sum = (FN(product)(&tail, &A[j], c + 1) + first * at) * inverse;
    k->r[c][j] = at - sum * first;
    FN(subtract)(&A[j], sum, &tail, c + 1);
  }
}

/* Column c of the products of the reflections. */
static inline void FN(set_gram)(FN(seven) * k, int c) {
  UNROLLED
  for (int i = 0; i < c; ++i)
    k->gram[i][c] = FN(product)(&k->v[i], &k->v[c], c);
}

/* Reflections and R of the Jacobian. */
static inline void FN(reduce)(FN(seven) * k) {
  FN(row) A[6]; /* columns of Jᵀ: rows of J */
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

/* [R⁻ᵀ b; last] of b[6]. */
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

/* Q x = x − V s, of products sum[c] = vᵀx. The products of the reflections among each other (Schreiber and Van Loan's compact
 * form) say what each leaves of the others' sums, so that none waits for what the one before has made of x. */
static inline FN(row) FN(back_by_products)(const FN(seven) * k, T *sum, FN(row) x) {
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

/* Q x. */
static inline FN(row) FN(turned_back)(const FN(seven) * k, FN(row) x) {
  T sum[6];
  UNROLLED
  for (int c = 0; c < 6; ++c)
    sum[c] = FN(product)(&k->v[c], &x, c);
  return FN(back_by_products)(k, sum, x);
}

/* The x with J x = b that is `along` long along the null vector; the least one for 0. */
static inline FN(row) FN(solve)(const FN(seven) * k, const T *b, T along) {
  return FN(turned_back)(k, FN(substitute)(k, b, along));
}

/* The null vector, once the Jacobian is reduced. */
static inline void FN(find_null)(FN(seven) * k) {
  const T last[SEVEN] = {ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO + 1.0};
  T sum[6];
  UNROLLED
  for (int c = 0; c < 6; ++c)
    sum[c] = FN(at)(&k->v[c], 6);
  k->null = FN(back_by_products)(k, sum, FN(row_of)(last, 1));
}

/* Reduces the Jacobian, and finds its null vector, the least rates with J rates = b, and the path's entry. */
static inline void FN(factor)(FN(seven) * k, const T *b) {
  FN(reduce)(k);
  FN(find_null)(k);
  FN(row) y = FN(substitute)(k, b, ZERO);
  k->path = 1.0 / ROOT(1.0 + FN(product)(&y, &y, 0)); /* Q keeps lengths */
  k->rates = FN(turned_back)(k, y);
}

/* How far x[7] goes along the null vector. */
static inline T FN(along_null)(const FN(seven) * k, const T *x) {
  FN(row) row = FN(row_of)(x, 1);
  return FN(product)(&k->null, &row, 0);
}

/* The turn from R to a target's axes, as a rotation vector in the inertial axes, for small ones: the skew part of the
 * difference is sin θ, and θ/sin θ a series. *sine2 is sin²θ, *trace 1 + 2 cos θ: where they aren't those of a small
 * turn the result is none. */
static inline FN(vec) FN(turn_left)(const FN(vec) * R, const FN(vec) * target, T *sine2, T *trace) {
  FN(vec) s = {ZERO, ZERO, ZERO};
  *trace = ZERO;
  for (int i = 0; i < 3; ++i) {
    FN(vec) c = FN(cross)(R[i], target[i]);
    s = (FN(vec)){s.x + c.x, s.y + c.y, s.z + c.z};
    *trace += FN(dot)(R[i], target[i]);
  }
  s = FN(scaled)(ZERO + 0.5, s);
  T x = FN(dot)(s, s);
  *sine2 = x;
  return FN(scaled)(1.0 + x * (1.0 / 6.0 + x * (3.0 / 40.0 + x * (15.0 / 336.0))), s);
}

/* (rates, 1)/√(1 + |rates|²) into path[8]. */
static inline void FN(path_column)(const FN(seven) * k, T *path) {
  UNROLLED
  for (int i = 0; i < SEVEN; ++i)
    path[i] = FN(at)(&k->rates, i) * k->path;
  path[SEVEN] = k->path;
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
