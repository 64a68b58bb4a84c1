/* Rotations as three columns (the rotated axes), and as unit quaternions of ball joints (docs/theory.md 1.6). */
#ifndef KM_SPATIAL_ROTATION_H
#define KM_SPATIAL_ROTATION_H

#include "spatial/sincos.h"
#include "spatial/vec3.h"

/* Angle below which sin(θ)/θ is computed by two terms of its series. */
#define KM_EXP_SERIES 1e-4
/* Angle in radians below which the rate of a rotation vector is computed by a series. */
#define KM_ROTATION_RATE_SERIES 1e-2

#define T                     double
#define FN(name)              km_##name
#define ALL(x)                (x)
#define ROOT                  sqrt
#define SINCOS                km_sincos
#define BELOW(a, limit, x, y) ((a) < (limit) ? (x) : (y))
#include "spatial/rotation_body.h"
#undef T
#undef FN
#undef ALL
#undef ROOT
#undef SINCOS
#undef BELOW

static inline km_rotation km_rotation_identity(void) {
  return (km_rotation){{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

/* Copies the matrix to row-major order, as in public structures. */
static inline void km_rotation_rows(const km_rotation *r, double rows[9]) {
  for (int k = 0; k < 3; ++k) {
    rows[k] = r->axis[k].x;
    rows[3 + k] = r->axis[k].y;
    rows[6 + k] = r->axis[k].z;
  }
}

/* Rᵀ a. */
static inline km_vec3 km_rotate_back(const km_rotation *r, km_vec3 a) {
  return (km_vec3){km_vec3_dot(r->axis[0], a), km_vec3_dot(r->axis[1], a), km_vec3_dot(r->axis[2], a)};
}

/* R · rot_k(angle): rotation about the own axis k (0, 1, 2). Twelve multiplications. */
static inline km_rotation km_rotation_about_axis(const km_rotation *r, int k, double cosine, double sine) {
  km_rotation out = *r;
  km_vec3_turn_about(out.axis, k, cosine, sine);
  return out;
}

/* Smallest rotation of coordinate axis k onto a unit vector u: R e_i = e_i − u_i / (1 + u_k) (e_k + u) for the other
 * axes. The identity if u is that axis, a half turn about the next axis if it is opposite. */
static inline km_rotation km_rotation_onto(int k, km_vec3 u) {
  const double c[3] = {u.x, u.y, u.z};
  int i = (k + 1) % 3, j = (k + 2) % 3;
  km_rotation R = km_rotation_identity();
  double across = c[i] * c[i] + c[j] * c[j], sum = c[k] < 0.0 ? across / (1.0 - c[k]) : 1.0 + c[k];
  km_vec3 middle = {k == 0 ? sum : u.x, k == 1 ? sum : u.y, k == 2 ? sum : u.z}; /* u plus the axis */
  R.axis[k] = u;
  if (across > 1e-280) { /* large enough for square roots with all digits */
    R.axis[i] = km_vec3_axpy(-c[i] / sum, middle, R.axis[i]);
    R.axis[j] = km_vec3_axpy(-c[j] / sum, middle, R.axis[j]);
  } else if (c[k] < 0.0) {
    R.axis[j] = km_vec3_scale(-1.0, R.axis[j]);
  }
  return R;
}

/* Orthonormalises a nearly orthonormal matrix by Gram-Schmidt from axis 0. */
static inline km_rotation km_rotation_orthonormal(const km_rotation *r) {
  km_vec3 x = km_vec3_scale(1.0 / km_vec3_norm(r->axis[0]), r->axis[0]);
  km_vec3 y = km_vec3_axpy(-km_vec3_dot(x, r->axis[1]), x, r->axis[1]);
  y = km_vec3_scale(1.0 / km_vec3_norm(y), y);
  return (km_rotation){{x, y, km_vec3_cross(x, y)}};
}

/* The largest difference of two entries. */
static inline double km_rotation_distance(const km_rotation *a, const km_rotation *b) {
  double most = 0.0;
  for (int k = 0; k < 3; ++k) {
    km_vec3 d = km_vec3_sub(a->axis[k], b->axis[k]);
    most = fmax(most, fmax(fabs(d.x), fmax(fabs(d.y), fabs(d.z))));
  }
  return most;
}

/* Rotation nearest to a matrix M of positive determinant: orthogonal factor of its polar decomposition, by Newton's
 * iteration X <- (X + X⁻ᵀ) / 2 from M (N. Higham, Functions of Matrices, section 8.3). Quadratic convergence; singular
 * values from 1/2 to 2 take at most 6 steps. */
static inline km_rotation km_rotation_nearest(const km_rotation *m) {
  km_rotation X = *m;
  for (int step = 0; step < 8; ++step) {
    km_rotation cofactor = {{km_vec3_cross(X.axis[1], X.axis[2]), km_vec3_cross(X.axis[2], X.axis[0]),
                             km_vec3_cross(X.axis[0], X.axis[1])}};
    double scale = 0.5 / km_vec3_dot(X.axis[0], cofactor.axis[0]);
    for (int k = 0; k < 3; ++k)
      X.axis[k] = km_vec3_axpy(scale, cofactor.axis[k], km_vec3_scale(0.5, X.axis[k]));
  }
  return X;
}

/* Rotation vector of a quaternion, with an angle of at most π. */
static inline km_vec3 km_quaternion_log(km_quaternion q) {
  if (q.w < 0.0)
    q = (km_quaternion){-q.w, -q.x, -q.y, -q.z};
  double sine = sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
  double s = sine < 1e-8 ? 2.0 : 2.0 * atan2(sine, q.w) / sine;
  return (km_vec3){s * q.x, s * q.y, s * q.z};
}

/* Rotation vector of a quaternion that is nearest to `near`, among all angles that differ by full turns. */
static inline km_vec3 km_quaternion_log_near(km_quaternion q, km_vec3 near) {
  km_vec3 v = km_quaternion_log(q);
  double angle = km_vec3_norm(v), length = km_vec3_norm(near);
  km_vec3 axis;
  if (angle > 1e-9)
    axis = km_vec3_scale(1.0 / angle, v);
  else if (length > 1e-9)
    axis = km_vec3_scale(1.0 / length, near);
  else
    return v;
  double turns = round((km_vec3_dot(axis, near) - angle) / (2.0 * M_PI));
  return turns == 0.0 ? v : km_vec3_scale(angle + 2.0 * M_PI * turns, axis);
}

/* Unit quaternion of a rotation matrix, from its largest component. */
static inline km_quaternion km_rotation_quaternion(const km_rotation *r) {
  double xx = r->axis[0].x, yy = r->axis[1].y, zz = r->axis[2].z;
  km_quaternion q;
  if (xx + yy + zz > 0.0)
    q = (km_quaternion){1 + xx + yy + zz, r->axis[1].z - r->axis[2].y, r->axis[2].x - r->axis[0].z,
                        r->axis[0].y - r->axis[1].x};
  else if (xx >= yy && xx >= zz)
    q = (km_quaternion){r->axis[1].z - r->axis[2].y, 1 + xx - yy - zz, r->axis[0].y + r->axis[1].x,
                        r->axis[2].x + r->axis[0].z};
  else if (yy >= zz)
    q = (km_quaternion){r->axis[2].x - r->axis[0].z, r->axis[0].y + r->axis[1].x, 1 + yy - zz - xx,
                        r->axis[1].z + r->axis[2].y};
  else
    q = (km_quaternion){r->axis[0].y - r->axis[1].x, r->axis[2].x + r->axis[0].z, r->axis[1].z + r->axis[2].y,
                        1 + zz - xx - yy};
  return km_quaternion_normalised(q);
}

#endif
