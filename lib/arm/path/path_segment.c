/* Shapes of path segments: line, helix, weave, spline. Each gives pose and derivative by u = 0 … 1.
 *
 *   spline orientations between knots: q0 exp(w1 β1) exp(w2 β2) exp(w3 β3), β cumulative cubic Bernstein polynomials
 *   body rate: Σ β_i'/h R_i w_i                     (M. Kim, M. Kim and S. Shin 1995; docs/theory.md 12.2) */
#include "arm/path/path.h"

#include <gsl/gsl_errno.h>
#include <string.h>

static km_rotation has_rotation(km_vec3 by, const km_rotation *R) {
  km_rotation turn = km_quaternion_rotation(km_quaternion_exp(by));
  return km_rotation_product(&turn, R);
}

static km_pose line_pose(const km_segment *g, double u, km_twist *rate) {
  *rate = (km_twist){g->travel, g->turn};
  return (km_pose){has_rotation(km_vec3_scale(u, g->turn), &g->start.R), km_vec3_axpy(u, g->travel, g->start.p)};
}

/* Pose and rate of a helix: rotation of the arm about the axis plus rise. */
static km_pose helix_pose(const km_segment *g, double u, km_twist *rate) {
  km_rotation turn = km_quaternion_rotation(km_quaternion_exp(km_vec3_scale(u * g->angle, g->axis)));
  km_vec3 arm = km_rotate(&turn, km_vec3_sub(g->start.p, g->centre));
  km_vec3 p = km_vec3_axpy(u * g->rise, g->axis, km_vec3_add(g->centre, arm));
  rate->v = km_vec3_axpy(g->rise, g->axis, km_vec3_scale(g->angle, km_vec3_cross(g->axis, arm)));
  rate->w = g->turn;
  return (km_pose){has_rotation(km_vec3_scale(u, g->turn), &g->start.R), p};
}

static km_pose weave_pose(const km_segment *g, double u, km_twist *rate) {
  double phase = 2.0 * M_PI * g->waves * u;
  km_pose pose = line_pose(g, u, rate);
  pose.p = km_vec3_axpy(sin(phase), g->sideways, pose.p);
  rate->v = km_vec3_axpy(2.0 * M_PI * g->waves * cos(phase), g->sideways, rate->v);
  return pose;
}

/* Cumulative Bernstein polynomials of degree 3 and their derivatives. */
static void bernstein(double x, double value[3], double rate[3]) {
  double y = 1.0 - x;
  value[0] = 1.0 - y * y * y;
  value[1] = x * x * (3.0 - 2.0 * x);
  value[2] = x * x * x;
  rate[0] = 3.0 * y * y;
  rate[1] = 6.0 * x * y;
  rate[2] = 3.0 * x * x;
}

/* Pose and rate of a spline: cubic positions, orientation by the product of three exponentials. */
static km_pose spline_pose(const km_segment *g, double u, km_twist *rate) {
  int k = 0;
  while (k < g->knots - 2 && u >= g->knot[k + 1])
    ++k;
  u = u < 0.0 ? 0.0 : u > 1.0 ? 1.0 : u;
  double p[3], v[3], h = g->knot[k + 1] - g->knot[k], value[3], slope[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = gsl_spline_eval(g->spline[i], u, NULL);
    v[i] = gsl_spline_eval_deriv(g->spline[i], u, NULL);
  }
  bernstein((u - g->knot[k]) / h, value, slope);
  km_quaternion q = g->piece[k].start;
  rate->v = km_vec3_from_array(v);
  rate->w = (km_vec3){0, 0, 0};
  for (int i = 0; i < 3; ++i) { /* each factor rotates about its own axis, fixed in the previous frame */
    km_rotation R = km_quaternion_rotation(q);
    rate->w = km_vec3_axpy(slope[i] / h, km_rotate(&R, g->piece[k].w[i]), rate->w);
    q = km_quaternion_product(q, km_quaternion_exp(km_vec3_scale(value[i], g->piece[k].w[i])));
  }
  return (km_pose){km_quaternion_rotation(km_quaternion_normalised(q)), km_vec3_from_array(p)};
}

km_pose km_segment_pose(const km_segment *g, double u, km_twist *rate) {
  switch (g->kind) {
  case KM_SEGMENT_HELIX:
    return helix_pose(g, u, rate);
  case KM_SEGMENT_WEAVE:
    return weave_pose(g, u, rate);
  case KM_SEGMENT_SPLINE:
    return spline_pose(g, u, rate);
  default:
    return line_pose(g, u, rate);
  }
}

/* Rotation vector from orientation a to b in the axes of a, at most half a turn. */
static km_vec3 step_between(km_quaternion a, km_quaternion b) {
  return km_quaternion_log(km_quaternion_product(km_quaternion_conjugate(a), b));
}

/* Fits the orientation pieces. The body rate at a knot is the mean of the rates before and after, weighted with the
 * other interval; at the ends, the only rate. */
static void fit_orientations(km_segment *g, const km_quaternion *q, km_vec3 *step, km_vec3 *rate) {
  int last = g->knots - 1;
  for (int k = 0; k < last; ++k)
    step[k] = km_vec3_scale(1.0 / (g->knot[k + 1] - g->knot[k]), step_between(q[k], q[k + 1]));
  rate[0] = step[0];
  rate[last] = step[last - 1];
  for (int k = 1; k < last; ++k) {
    double before = g->knot[k] - g->knot[k - 1], after = g->knot[k + 1] - g->knot[k];
    rate[k] = km_vec3_scale(1.0 / (before + after), km_vec3_axpy(after, step[k - 1], km_vec3_scale(before, step[k])));
  }
  for (int k = 0; k < last; ++k) {
    double third = (g->knot[k + 1] - g->knot[k]) / 3.0;
    km_orientation_piece *piece = &g->piece[k];
    piece->start = q[k];
    piece->w[0] = km_vec3_scale(third, rate[k]);
    piece->w[2] = km_vec3_scale(third, rate[k + 1]);
    km_quaternion from = km_quaternion_product(q[k], km_quaternion_exp(piece->w[0]));
    km_quaternion to = km_quaternion_product(q[k + 1], km_quaternion_exp(km_vec3_scale(-1.0, piece->w[2])));
    piece->w[1] = step_between(from, to);
  }
}

static bool fit_position(km_segment *g, int axis, const km_pose *poses, double *value) {
  for (int k = 0; k < g->knots; ++k)
    value[k] = axis == 0 ? poses[k].p.x : axis == 1 ? poses[k].p.y : poses[k].p.z;
  const gsl_interp_type *type = g->knots > 2 ? gsl_interp_cspline : gsl_interp_linear;
  g->spline[axis] = gsl_spline_alloc(type, (size_t)g->knots);
  return g->spline[axis] && gsl_spline_init(g->spline[axis], g->knot, value, (size_t)g->knots) == GSL_SUCCESS;
}

/* Fits cubic splines to the positions and orientation pieces to the rotations. */
km_status km_segment_fit(km_segment *g, const km_pose *poses, km_arena *arena, km_error *error) {
  size_t count = (size_t)g->knots;
  gsl_set_error_handler_off();
  double *value = KM_ARENA_NEW(arena, double, count);
  km_quaternion *q = KM_ARENA_NEW(arena, km_quaternion, count);
  km_vec3 *step = KM_ARENA_NEW(arena, km_vec3, count), *rate = KM_ARENA_NEW(arena, km_vec3, count);
  g->piece = KM_ARENA_NEW(arena, km_orientation_piece, count);
  bool is_ok = !arena->failed;
  for (int axis = 0; axis < 3 && is_ok; ++axis)
    is_ok = fit_position(g, axis, poses, value);
  if (!is_ok)
    return km_fail(error, KM_MEMORY, "out of memory for a spline of %d points", g->knots);
  for (int k = 0; k < g->knots; ++k)
    q[k] = km_rotation_quaternion(&poses[k].R);
  fit_orientations(g, q, step, rate);
  g->start = poses[0];
  return KM_OK;
}
