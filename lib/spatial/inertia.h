/* Spatial inertias (docs/theory.md 1.2, 11.2): rigid bodies (ten numbers) and articulated bodies (21 numbers), about
 * the origin of the frame in which they are expressed.
 *
 *   rigid      : f = m v − mc × ω,  τ = mc × v + I ω                (49)-(59)
 *   articulated: f = M v + H ω,     τ = Hᵀ v + I ω                  a body with all that is eliminated onto it */
#ifndef KM_SPATIAL_INERTIA_H
#define KM_SPATIAL_INERTIA_H

#include "spatial/wrench.h"

/* Symmetric 3 × 3 matrices are xx yy zz xy yz zx. */
typedef struct km_symmetric {
  double xx, yy, zz, xy, yz, zx;
} km_symmetric;

/* Inertia of a rigid body; massless if all 0. */
typedef struct km_inertia {
  double m;
  km_vec3 mc;     /* mass times centre of mass */
  km_symmetric I; /* inertia matrix about the origin */
} km_inertia;

/* Articulated inertia, a symmetric 6 × 6 matrix in blocks. */
typedef struct km_articulated {
  km_symmetric M, I;
  double H[9]; /* row-major */
} km_articulated;

static inline km_vec3 km_symmetric_times(const km_symmetric *S, km_vec3 a) {
  return (km_vec3){S->xx * a.x + S->xy * a.y + S->zx * a.z, S->xy * a.x + S->yy * a.y + S->yz * a.z,
                   S->zx * a.x + S->yz * a.y + S->zz * a.z};
}

static inline km_symmetric km_symmetric_axpy(double s, km_symmetric a, km_symmetric b) { /* s a + b */
  return (km_symmetric){s * a.xx + b.xx, s * a.yy + b.yy, s * a.zz + b.zz,
                        s * a.xy + b.xy, s * a.yz + b.yz, s * a.zx + b.zx};
}

/* a bᵀ + b aᵀ */
static inline km_symmetric km_symmetric_product(km_vec3 a, km_vec3 b) {
  return (km_symmetric){2.0 * a.x * b.x,       2.0 * a.y * b.y,       2.0 * a.z * b.z,
                        a.x * b.y + a.y * b.x, a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z};
}

/* R S Rᵀ */
static inline km_symmetric km_symmetric_rotated(const km_rotation *R, const km_symmetric *S) {
  const km_vec3 *a = R->axis;
  /* T = R S by columns; then T Rᵀ. */
  km_vec3 t0 = km_vec3_axpy(S->xx, a[0], km_vec3_axpy(S->xy, a[1], km_vec3_scale(S->zx, a[2])));
  km_vec3 t1 = km_vec3_axpy(S->xy, a[0], km_vec3_axpy(S->yy, a[1], km_vec3_scale(S->yz, a[2])));
  km_vec3 t2 = km_vec3_axpy(S->zx, a[0], km_vec3_axpy(S->yz, a[1], km_vec3_scale(S->zz, a[2])));
  return (km_symmetric){t0.x * a[0].x + t1.x * a[1].x + t2.x * a[2].x, t0.y * a[0].y + t1.y * a[1].y + t2.y * a[2].y,
                        t0.z * a[0].z + t1.z * a[1].z + t2.z * a[2].z, t0.x * a[0].y + t1.x * a[1].y + t2.x * a[2].y,
                        t0.y * a[0].z + t1.y * a[1].z + t2.y * a[2].z, t0.z * a[0].x + t1.z * a[1].x + t2.z * a[2].x};
}

/* Sum of two inertias in one frame. */
static inline km_inertia km_inertia_add(km_inertia a, km_inertia b) {
  return (km_inertia){a.m + b.m, km_vec3_add(a.mc, b.mc), km_symmetric_axpy(1.0, a.I, b.I)};
}

/* Transforms an inertia from a child frame X to the parent frame: mc' = R mc + m p, I' = R I Rᵀ + 2 (p·u) 1 − (p uᵀ + u
 * pᵀ), u = R mc + m p / 2. */
static inline km_inertia km_inertia_transform(const km_pose *X, const km_inertia *a) {
  km_vec3 s = km_rotate(&X->R, a->mc), u = km_vec3_axpy(0.5 * a->m, X->p, s);
  double trace = 2.0 * km_vec3_dot(X->p, u);
  km_symmetric rotated = km_symmetric_rotated(&X->R, &a->I), pair = km_symmetric_product(X->p, u);
  km_symmetric I = km_symmetric_axpy(-1.0, pair, rotated);
  I.xx += trace;
  I.yy += trace;
  I.zz += trace;
  return (km_inertia){a->m, km_vec3_axpy(a->m, X->p, s), I};
}

/* Inertia about the origin of a body with its centre of mass at c and the inertia matrix I about it. */
static inline km_inertia km_inertia_of_body(double mass, km_vec3 c, const double I[6]) {
  km_inertia about = {mass, {0, 0, 0}, {I[0], I[1], I[2], I[3], I[4], I[5]}};
  km_pose X = {km_rotation_identity(), c};
  return km_inertia_transform(&X, &about);
}

/* Momentum of a twist, or force of a spatial acceleration. */
static inline km_wrench km_inertia_times(const km_inertia *a, km_twist x) {
  km_vec3 f = km_vec3_axpy(a->m, x.v, km_vec3_cross(x.w, a->mc));
  return (km_wrench){f, km_vec3_add(km_vec3_cross(a->mc, x.v), km_symmetric_times(&a->I, x.w))};
}

/* Wrench of an articulated inertia for a twist or an acceleration x. */
static inline km_wrench km_articulated_times(const km_articulated *a, km_twist x) {
  const double *H = a->H;
  km_vec3 f = km_symmetric_times(&a->M, x.v), t = km_symmetric_times(&a->I, x.w);
  f = km_vec3_add(f, (km_vec3){H[0] * x.w.x + H[1] * x.w.y + H[2] * x.w.z, H[3] * x.w.x + H[4] * x.w.y + H[5] * x.w.z,
                               H[6] * x.w.x + H[7] * x.w.y + H[8] * x.w.z});
  t = km_vec3_add(t, (km_vec3){H[0] * x.v.x + H[3] * x.v.y + H[6] * x.v.z, H[1] * x.v.x + H[4] * x.v.y + H[7] * x.v.z,
                               H[2] * x.v.x + H[5] * x.v.y + H[8] * x.v.z});
  return (km_wrench){f, t};
}

/* a += the inertia of a rigid body. */
static inline void km_articulated_add_body(km_articulated *a, const km_inertia *b) {
  a->M.xx += b->m;
  a->M.yy += b->m;
  a->M.zz += b->m;
  a->I = km_symmetric_axpy(1.0, b->I, a->I);
  /* f = ω × mc = −mc~ ω */
  a->H[1] += b->mc.z;
  a->H[2] -= b->mc.y;
  a->H[3] -= b->mc.z;
  a->H[5] += b->mc.x;
  a->H[6] += b->mc.y;
  a->H[7] -= b->mc.x;
}

/* Adds an articulated inertia. */
static inline void km_articulated_add(km_articulated *a, const km_articulated *b) {
  a->M = km_symmetric_axpy(1.0, b->M, a->M);
  a->I = km_symmetric_axpy(1.0, b->I, a->I);
  for (int i = 0; i < 9; ++i)
    a->H[i] += b->H[i];
}

/* a += s u uᵀ */
static inline void km_articulated_add_outer_product(km_articulated *a, double s, km_wrench u) {
  a->M = km_symmetric_axpy(0.5 * s, km_symmetric_product(u.f, u.f), a->M);
  a->I = km_symmetric_axpy(0.5 * s, km_symmetric_product(u.t, u.t), a->I);
  const double f[3] = {s * u.f.x, s * u.f.y, s * u.f.z}, t[3] = {u.t.x, u.t.y, u.t.z};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      a->H[3 * r + c] += f[r] * t[c];
}

/* Cross product V ×* w: rate of change of a wrench that is carried with twist V. */
static inline km_wrench km_wrench_cross(km_twist V, km_wrench w) {
  return (km_wrench){km_vec3_cross(V.w, w.f), km_vec3_add(km_vec3_cross(V.w, w.t), km_vec3_cross(V.v, w.f))};
}

#endif
