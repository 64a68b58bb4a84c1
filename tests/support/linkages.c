/* Linkages by their axes. */
#include "support/linkages.h"

#include <lapacke.h>
#include <stdio.h>
#include <stdlib.h>

km_vec3 random_point(randomness *r) {
  return (km_vec3){uniform(r, -1, 1), uniform(r, -1, 1), uniform(r, -1, 1)};
}

km_vec3 random_direction(randomness *r) {
  for (;;) {
    km_vec3 v = random_point(r);
    double size = km_vec3_norm(v);
    if (size > 0.2 && size < 1.0)
      return km_vec3_scale(1.0 / size, v);
  }
}

static double cut(double value, int digits) {
  char text[64];
  if (digits <= 0)
    return value;
  snprintf(text, sizeof text, "%.*g", digits, value);
  return strtod(text, NULL);
}

static void write_frame(km_text *out, const char *end, int joint, const km_pose *X, int digits) {
  const km_vec3 *a = X->R.axis;
  int d = digits > 0 && digits < 7 ? 7 : digits;
  km_text_format(out,
                 "%s{\"name\": \"%s%d\", \"T\": [%.17g, %.17g, %.17g], \"R\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, "
                 "%.17g], [%.17g, %.17g, %.17g]]}",
                 out->size ? ", " : "", end, joint, cut(X->p.x, digits), cut(X->p.y, digits), cut(X->p.z, digits),
                 cut(a[0].x, d), cut(a[1].x, d), cut(a[2].x, d), cut(a[0].y, d), cut(a[1].y, d), cut(a[2].y, d),
                 cut(a[0].z, d), cut(a[1].z, d), cut(a[2].z, d));
}

static km_pose axis_frame(const axis_joint *j, const writing *how, randomness *r) {
  km_vec3 z = j->along, x = km_vec3_perpendicular(z);
  km_pose X = {{{x, km_vec3_cross(z, x), z}}, km_vec3_scale(how->size, j->at)};
  if (!how->own_frames)
    return X;
  double turn = uniform(r, -3, 3);
  X.R = km_rotation_about_axis(&X.R, 2, cos(turn), sin(turn));
  X.p = km_vec3_axpy(how->size * uniform(r, -0.3, 0.3), z, X.p);
  return X;
}

static const char *body_name(int body, char out[16]) {
  snprintf(out, 16, body ? "b%d" : "fixed", body);
  return out;
}

static void write_joint(const linkage *l, int index, const writing *how, randomness *r, const km_pose *own,
                        km_text *frames, km_text *joints) {
  const axis_joint *j = &l->joint[index];
  char parent[16], child[16];
  km_pose X = axis_frame(j, how, r), there = X;
  double q = how->own_frames ? uniform(r, -1, 1) * (j->slides ? 0.3 * how->size : 1.0) : 0.0;
  if (j->slides)
    there.p = km_vec3_axpy(q, X.R.axis[2], X.p);
  else
    there.R = km_rotation_about_axis(&X.R, 2, cos(q), sin(q));
  km_pose a = km_pose_product(&own[j->parent], &X), b = km_pose_product(&own[j->child], &there);
  write_frame(&frames[j->parent], "p", index, &a, how->digits);
  write_frame(&frames[j->child], "c", index, &b, how->digits);
  km_text_format(joints,
                 "%s{\"name\": \"J%d\", \"type\": \"%s\", \"body_frame_pairs\": [[\"%s\", \"p%d\"], [\"%s\", "
                 "\"c%d\"]], \"initial_displacement\": %.17g}",
                 index ? ", " : "", index, j->slides ? "Tz" : "Rz", body_name(j->parent, parent), index,
                 body_name(j->child, child), index, cut(q, how->digits));
}

char *linkage_text(const linkage *l, writing how, randomness *r) {
  km_pose own[MOST_AXES + 1];
  km_text frames[MOST_AXES + 1] = {{0}}, joints = {0}, out = {0};
  how.size = how.size > 0.0 ? how.size : 1.0;
  for (int b = 0; b <= l->bodies; ++b) {
    own[b] = km_pose_identity();
    if (b && how.own_frames)
      own[b] = (km_pose){km_quaternion_rotation(km_quaternion_exp(random_point(r))),
                         km_vec3_scale(0.3 * how.size, random_point(r))};
  }
  for (int j = 0; j < l->joints; ++j)
    write_joint(l, j, &how, r, own, frames, &joints);
  km_text_add(&out, "{\"model_parameters\": {");
  if (how.tolerance > 0.0)
    km_text_format(&out, "\"closure_tolerance\": %.17g", how.tolerance);
  km_text_format(&out, "}, \"fixed\": {\"frames\": [%s]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [",
                 frames[0].data ? frames[0].data : "");
  for (int b = 1; b <= l->bodies; ++b)
    km_text_format(&out, "%s{\"name\": \"b%d\", \"frames\": [%s]}", b > 1 ? ", " : "", b,
                   frames[b].data ? frames[b].data : "");
  km_text_format(&out, "], \"joints\": [%s]}]}", joints.data);
  for (int b = 0; b <= l->bodies; ++b)
    km_text_free(&frames[b]);
  km_text_free(&joints);
  return out.data;
}

linkage hinged_loop(const km_vec3 *at, const km_vec3 *along, int count) {
  linkage l = {.bodies = count - 1, .joints = count};
  for (int j = 0; j < count; ++j)
    l.joint[j] = (axis_joint){j, (j + 1) % count, false, at[j], along[j]};
  return l;
}

/* Axes of a chain of Denavit and Hartenberg: R_z(θ) T_x(a) R_x(α) from each to the next. */
static void denavit_hartenberg(const double *angle, const double *length, const double *twist, int count, km_vec3 *at,
                               km_vec3 *along) {
  km_pose X = km_pose_identity();
  for (int j = 0; j < count; ++j) {
    at[j] = X.p;
    along[j] = X.R.axis[2];
    X.R = km_rotation_about_axis(&X.R, 2, cos(angle[j]), sin(angle[j]));
    X.p = km_vec3_axpy(length[j], X.R.axis[0], X.p);
    X.R = km_rotation_about_axis(&X.R, 0, cos(twist[j]), sin(twist[j]));
  }
}

/* a/sin α = b/sin β; tan(θ₁/2) tan(θ₂/2) = sin((β + α)/2)/sin((β − α)/2). */
static linkage bennett(randomness *r) {
  double alpha = uniform(r, 0.3, 1.2), beta = uniform(r, alpha + 0.2, 2.5), a = uniform(r, 0.3, 1.0);
  double b = a * sin(beta) / sin(alpha), first = uniform(r, 0.4, 2.4);
  double second = 2.0 * atan(sin(0.5 * (beta + alpha)) / sin(0.5 * (beta - alpha)) / tan(0.5 * first));
  km_vec3 at[4], along[4];
  denavit_hartenberg((double[]){first, second, -first, -second}, (double[]){a, b, a, b},
                     (double[]){alpha, beta, alpha, beta}, 4, at, along);
  return hinged_loop(at, along, 4);
}

/* Lines 4, 5, 6 are lines 1, 2, 3 turned by half a turn about the z axis, or mirrored at the plane z = 0 that holds
 * lines 1 and 4. */
static linkage bricard(randomness *r, bool mirrored) {
  km_vec3 at[6], along[6];
  for (int j = 0; j < 6; ++j) {
    bool inside = mirrored && j % 3 == 0;
    at[j] = random_point(r);
    along[j] = random_direction(r);
    if (inside) {
      at[j].z = 0.0;
      along[j] = km_vec3_scale(1.0 / hypot(along[j].x, along[j].y), (km_vec3){along[j].x, along[j].y, 0.0});
    }
  }
  for (int j = 0; j < 3; ++j) {
    if (!mirrored) {
      at[j + 3] = (km_vec3){-at[j].x, -at[j].y, at[j].z};
      along[j + 3] = (km_vec3){-along[j].x, -along[j].y, along[j].z};
    } else if (j > 0) {
      at[6 - j] = (km_vec3){at[j].x, at[j].y, -at[j].z};
      along[6 - j] = (km_vec3){along[j].x, along[j].y, -along[j].z};
    }
  }
  return hinged_loop(at, along, 6);
}

/* Two groups of three parallel axes. */
static linkage sarrus(randomness *r) {
  km_vec3 at[6], along[6], u = random_direction(r), v = random_direction(r);
  for (int j = 0; j < 6; ++j) {
    at[j] = random_point(r);
    along[j] = j < 3 ? u : v;
  }
  return hinged_loop(at, along, 6);
}

static linkage planar_or_spherical(randomness *r, bool spherical) {
  km_vec3 at[4], along[4], z = random_direction(r), x = km_vec3_perpendicular(z), y = km_vec3_cross(z, x);
  static const double corners[4][2] = {{0, 0}, {0.2, 0.6}, {1.0, 0.9}, {1.2, 0}};
  for (int j = 0; j < 4; ++j) {
    double a = corners[j][0] + uniform(r, -0.1, 0.1), b = corners[j][1] + uniform(r, -0.1, 0.1);
    km_vec3 p = km_vec3_axpy(a, x, km_vec3_axpy(b, y, z));
    at[j] = spherical ? (km_vec3){0, 0, 0} : p;
    along[j] = spherical ? km_vec3_scale(1.0 / km_vec3_norm(p), p) : z;
  }
  return hinged_loop(at, along, 4);
}

/* A crank as long as the rod, whose end runs through the crank's pivot: a point of the rod's far end stays on a line
 * through that pivot too, and a slot there is one constraint too many. */
static linkage elliptic_trammel(randomness *r) {
  double angle = uniform(r, 0.3, 1.2), reach = uniform(r, 0.5, 1.5);
  km_vec3 z = {0, 0, 1}, o = {0, 0, 0}, b = {reach * cos(angle), reach * sin(angle), 0};
  km_vec3 slider = {2 * b.x, 0, 0}, other = {0, 2 * b.y, 0};
  return (linkage){4,
                   6,
                   {{0, 1, false, o, z},
                    {1, 2, false, b, z},
                    {2, 3, false, slider, z},
                    {0, 3, true, slider, {1, 0, 0}},
                    {2, 4, false, other, z},
                    {0, 4, true, other, {0, 1, 0}}}};
}

/* A parallelogram with a third crank. */
static linkage three_cranks(randomness *r) {
  km_vec3 z = {0, 0, 1}, crank = {uniform(r, -0.8, 0.8), uniform(r, 0.3, 1), 0};
  linkage l = {.bodies = 4, .joints = 6};
  for (int k = 0; k < 3; ++k) {
    km_vec3 p = {uniform(r, -1, 1), uniform(r, -1, 1), 0};
    l.joint[2 * k] = (axis_joint){0, 1 + k, false, p, z};
    l.joint[2 * k + 1] = (axis_joint){1 + k, 4, false, km_vec3_add(p, crank), z};
  }
  return l;
}

const char *const moving_names[MOVING_KINDS] = {"Bennett",
                                                "line-symmetric Bricard",
                                                "plane-symmetric Bricard",
                                                "Sarrus",
                                                "planar 4R",
                                                "spherical 4R",
                                                "trammel",
                                                "three cranks"};

linkage moving_loop(int kind, randomness *r) {
  switch (kind) {
  case 0:
    return bennett(r);
  case 1:
  case 2:
    return bricard(r, kind == 2);
  case 3:
    return sarrus(r);
  case 4:
  case 5:
    return planar_or_spherical(r, kind == 5);
  case 6:
    return elliptic_trammel(r);
  default:
    return three_cranks(r);
  }
}

/* The singular value that the loop's screws keep least, over the largest. */
static double least_kept(const linkage *l, int rank) {
  double J[6 * MOST_AXES], values[6], rest[5];
  for (int j = 0; j < l->joints; ++j) {
    km_vec3 w = l->joint[j].along, v = km_vec3_cross(l->joint[j].at, w);
    const double column[6] = {v.x, v.y, v.z, w.x, w.y, w.z};
    for (int k = 0; k < 6; ++k)
      J[6 * j + k] = column[k];
  }
  LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'N', 'N', 6, l->joints, J, 6, values, NULL, 6, NULL, l->joints, rest);
  return values[rank - 1] / values[0];
}

linkage nearly_singular_loop(int kind, int count, randomness *r) {
  linkage best = moving_loop(kind, r);
  for (int i = 1; i < count && kind < 6; ++i) {
    linkage other = moving_loop(kind, r);
    if (least_kept(&other, other.joints - 1) < least_kept(&best, best.joints - 1))
      best = other;
  }
  return best;
}

fixture linkage_open(const linkage *l, randomness *r) {
  char *json = linkage_text(l, (writing){.own_frames = below(r, 2)}, r);
  fixture f = fixture_read(json);
  km_free(json);
  return f;
}
