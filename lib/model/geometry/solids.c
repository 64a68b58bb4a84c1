/* Mass properties of primitive solids; rigid displacement and sum. */
#include "model/geometry/solids.h"

#include <math.h>

/* R I Rᵀ. */
static void turn_inertia(const km_rotation *R, const double I[6], double out[6]) {
  double rows[9], half[9];
  const double A[9] = {I[0], I[3], I[5], I[3], I[1], I[4], I[5], I[4], I[2]};
  static const int at[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  km_rotation_rows(R, rows);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      half[3 * i + j] = rows[3 * i] * A[j] + rows[3 * i + 1] * A[3 + j] + rows[3 * i + 2] * A[6 + j];
  for (int k = 0; k < 6; ++k) {
    const double *a = &half[3 * at[k][0]], *b = &rows[3 * at[k][1]];
    out[k] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
}

km_mass km_mass_moved(const km_pose *pose, km_mass mass) {
  km_mass out = {.mass = mass.mass, .center = km_pose_point(pose, mass.center)};
  turn_inertia(&pose->R, mass.inertia, out.inertia);
  return out;
}

/* Adds the inertia of a point mass at d (parallel axis theorem). */
static void add_about(double sum[6], const km_mass *part, km_vec3 d) {
  double m = part->mass;
  const double far[6] = {
      d.y * d.y + d.z * d.z, d.z * d.z + d.x * d.x, d.x * d.x + d.y * d.y, -d.x * d.y, -d.y * d.z, -d.z * d.x};
  for (int k = 0; k < 6; ++k)
    sum[k] += part->inertia[k] + m * far[k];
}

km_mass km_mass_sum(km_mass a, km_mass b) {
  km_mass out = {.mass = a.mass + b.mass};
  if (!(out.mass > 0.0))
    return a;
  out.center = km_vec3_scale(1.0 / out.mass, km_vec3_axpy(a.mass, a.center, km_vec3_scale(b.mass, b.center)));
  add_about(out.inertia, &a, km_vec3_sub(a.center, out.center));
  add_about(out.inertia, &b, km_vec3_sub(b.center, out.center));
  return out;
}

km_mass km_mass_scaled(double factor, km_mass mass) {
  mass.mass *= factor;
  for (int k = 0; k < 6; ++k)
    mass.inertia[k] *= factor;
  return mass;
}

/* A solid with planar second moments m a, m b, m c. */
static km_mass symmetric(double m, double a, double b, double c) {
  return (km_mass){.mass = m, .inertia = {m * (b + c), m * (c + a), m * (a + b), 0, 0, 0}};
}

km_mass km_solid_box(const double h[3]) {
  return symmetric(8.0 * h[0] * h[1] * h[2], h[0] * h[0] / 3.0, h[1] * h[1] / 3.0, h[2] * h[2] / 3.0);
}

km_mass km_solid_ellipsoid(const double h[3]) {
  return symmetric(4.0 / 3.0 * M_PI * h[0] * h[1] * h[2], h[0] * h[0] / 5.0, h[1] * h[1] / 5.0, h[2] * h[2] / 5.0);
}

km_mass km_solid_cylinder(double r, double h) {
  return symmetric(2.0 * M_PI * r * r * h, r * r / 4.0, r * r / 4.0, h * h / 3.0);
}

km_mass km_solid_capsule(double r, double h) {
  const double ball[3] = {r, r, r};
  km_mass sum = km_solid_cylinder(r, h), cap = km_solid_ellipsoid(ball);
  /* The caps are two halves of a ball; the centre of a half is 3r/8 from its cut. */
  double m = cap.mass, second = r * r / 5.0 + 2.0 * h * (3.0 / 8.0 * r) + h * h;
  km_mass caps = symmetric(m, r * r / 5.0, r * r / 5.0, second);
  sum.mass += m;
  for (int k = 0; k < 6; ++k)
    sum.inertia[k] += caps.inertia[k];
  return sum;
}

km_mass km_solid_cone(double r, double h) {
  km_mass cone = symmetric(2.0 / 3.0 * M_PI * r * r * h, 0.15 * r * r, 0.15 * r * r, 0.15 * h * h);
  cone.center.z = -0.5 * h;
  return cone;
}
