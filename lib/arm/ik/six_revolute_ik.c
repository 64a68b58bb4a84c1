/* Closed-form inverse kinematics of six hinges of which three neighbouring axes are concurrent or parallel
 * (Pieper's method; docs/theory.md 12.9).
 *
 * The product of rotations e₁ … e₆ = T is given. Hinges i, i + 1, i + 2 make the group G, the others are A before
 * and B after it: G⁻¹ = B T⁻¹ A. Hence Ra Rb Rc = T G⁻¹, with a, b, c the hinges of B, moved by T, then those of A.
 *
 *   concurrent: G fixes the common point c          Ra Rb Rc c = T c
 *   parallel  : G fixes the direction d             Ra Rb Rc d = T d,   d · (G⁻¹ o − o) = 0
 *   u = Ra⁻¹ (right side) and w = Rc (left side) lie on circles;   Rb w = u
 *
 * Rb w = u holds if u and w have the same coordinate along axis b and (concurrent) the same distance from a point
 * of b, or (parallel) the same coordinate along d. These two equations are linear in (cos a, sin a, cos c, sin c):
 * up to four pairs of angles. Rb is the rotation from w to u; the group's angles have two solutions for each pair. */
#include "arm/ik/six_revolute_ik.h"

#include "arm/ik/trigonometric_equations.h"

#include <string.h>

static km_rotation rotation_about(km_vec3 axis, double angle) {
  return km_quaternion_rotation(km_quaternion_exp(km_vec3_scale(angle, axis)));
}

static km_vec3 has_rotation(km_vec3 axis, double angle, km_vec3 x) {
  km_rotation R = rotation_about(axis, angle);
  return km_rotate(&R, x);
}

static km_pose motion(const km_hinge *h, double angle) {
  km_pose pose = {rotation_about(h->axis, angle), {0, 0, 0}};
  pose.p = km_vec3_sub(h->point, km_rotate(&pose.R, h->point));
  return pose;
}

static km_vec3 perpendicular_part(km_vec3 axis, km_vec3 x) {
  return km_vec3_axpy(-km_vec3_dot(axis, x), axis, x);
}

/* Angle about an axis from one direction to another, both projected perpendicular to the axis; 0 if one is parallel
 * to it. */
static double angle_between(km_vec3 axis, km_vec3 from, km_vec3 to) {
  km_vec3 a = perpendicular_part(axis, from), b = perpendicular_part(axis, to);
  return atan2(km_vec3_dot(axis, km_vec3_cross(a, b)), km_vec3_dot(a, b));
}

/* Circle of x rotated about an axis by ±θ: offset + cos θ · cosine + sin θ · sine. */
typedef struct circle {
  km_vec3 offset, cosine, sine;
} circle;

static circle circle_of(km_vec3 axis, km_vec3 x, double sense) {
  km_vec3 cosine = perpendicular_part(axis, x);
  return (circle){km_vec3_sub(x, cosine), cosine, km_vec3_scale(sense, km_vec3_cross(axis, x))};
}

static km_vec3 on_circle(const circle *c, double angle) {
  return km_vec3_axpy(sin(angle), c->sine, km_vec3_axpy(cos(angle), c->cosine, c->offset));
}

/* The three hinges outside the group, in the order of the closed loop, and the circles of u and w. */
typedef struct outer_hinges {
  km_hinge a, b, c;
  circle u, w;
  km_vec3 origin; /* point on axis b, origin of u and w */
} outer_hinges;

/* Coefficients out[5] of cos a, sin a, cos c, sin c and 1 in f · u + g · w + constant. */
static void linear_equation(const outer_hinges *s, km_vec3 search, km_vec3 g, double constant, double *out) {
  out[0] = km_vec3_dot(search, s->u.cosine);
  out[1] = km_vec3_dot(search, s->u.sine);
  out[2] = km_vec3_dot(g, s->w.cosine);
  out[3] = km_vec3_dot(g, s->w.sine);
  out[4] = km_vec3_dot(search, s->u.offset) + km_vec3_dot(g, s->w.offset) + constant;
}

static double square(km_vec3 a) {
  return km_vec3_dot(a, a);
}

/* Equations of the concurrent group; u and w are relative to a point of axis b. */
static void equations_concurrent(const km_six_hinges *six, const km_pose *T, outer_hinges *s, double out[2][5]) {
  km_vec3 to = km_pose_point(T, six->centre);
  s->origin = s->b.point;
  s->u = circle_of(s->a.axis, km_vec3_sub(to, s->a.point), -1.0);
  s->w = circle_of(s->c.axis, km_vec3_sub(six->centre, s->c.point), 1.0);
  s->u.offset = km_vec3_add(s->u.offset, km_vec3_sub(s->a.point, s->origin));
  s->w.offset = km_vec3_add(s->w.offset, km_vec3_sub(s->c.point, s->origin));
  linear_equation(s, s->b.axis, km_vec3_scale(-1.0, s->b.axis), 0.0, out[0]);
  /* |u|² = |still|² + |cosine|² + 2 still · (cos cosine + sin sine) */
  out[1][0] = 2.0 * km_vec3_dot(s->u.offset, s->u.cosine);
  out[1][1] = 2.0 * km_vec3_dot(s->u.offset, s->u.sine);
  out[1][2] = -2.0 * km_vec3_dot(s->w.offset, s->w.cosine);
  out[1][3] = -2.0 * km_vec3_dot(s->w.offset, s->w.sine);
  out[1][4] = square(s->u.offset) + square(s->u.cosine) - square(s->w.offset) - square(s->w.cosine);
}

static void equations_parallel(const km_six_hinges *six, const km_pose *T, outer_hinges *s, double out[2][5]) {
  km_vec3 d = six->hinges[six->first].axis, to = km_rotate(&T->R, d);
  s->u = circle_of(s->a.axis, to, -1.0);
  s->w = circle_of(s->c.axis, d, 1.0);
  s->origin = (km_vec3){0, 0, 0};
  linear_equation(s, s->b.axis, km_vec3_scale(-1.0, s->b.axis), 0.0, out[0]);
  double constant = km_vec3_dot(to, km_vec3_sub(s->a.point, T->p)) - km_vec3_dot(d, s->c.point);
  linear_equation(s, km_vec3_sub(s->b.point, s->a.point), km_vec3_sub(s->c.point, s->b.point), constant, out[1]);
}

/* The three hinges outside the group in cyclic order; those after the group are moved by T. */
static outer_hinges outer_hinges_of(const km_six_hinges *six, const km_pose *T, int index[3]) {
  km_hinge order[3];
  for (int k = 0; k < 3; ++k) {
    index[k] = (six->first + 3 + k) % KM_SIX;
    order[k] = six->hinges[index[k]];
    if (six->first + 3 + k < KM_SIX) {
      order[k].point = km_pose_point(T, order[k].point);
      order[k].axis = km_rotate(&T->R, order[k].axis);
    }
  }
  return (outer_hinges){.a = order[0], .b = order[1], .c = order[2]};
}

/* Angles out[2][3] of the group's three hinges for a given G; returns the number of solutions. */
static int solve_group(const km_six_hinges *six, const km_pose *G, double (*out)[3]) {
  const km_hinge *h = six->hinges + six->first;
  km_vec3 n = h[0].axis, from, to; /* e₁ e₂ maps `from` to `to` */
  double line[3], middle[2];
  circle c;
  if (six->group == KM_GROUP_CONCURRENT) {
    from = h[2].axis;
    to = km_rotate(&G->R, from);
    c = circle_of(h[1].axis, from, 1.0);
    line[0] = km_vec3_dot(n, c.cosine);
    line[1] = km_vec3_dot(n, c.sine);
    line[2] = km_vec3_dot(n, c.offset) - km_vec3_dot(n, to);
  } else {
    from = km_vec3_sub(h[2].point, h[1].point);
    to = perpendicular_part(n, km_vec3_sub(km_pose_point(G, h[2].point), h[0].point));
    c = circle_of(h[1].axis, from, 1.0);
    c.offset = km_vec3_add(c.offset, km_vec3_sub(h[1].point, h[0].point));
    c.offset = perpendicular_part(n, c.offset);
    line[0] = 2.0 * km_vec3_dot(c.offset, c.cosine);
    line[1] = 2.0 * km_vec3_dot(c.offset, c.sine);
    line[2] = square(c.offset) + square(c.cosine) - square(to);
  }
  int count = km_solve_cos_sin(line, middle);
  for (int i = 0; i < count; ++i) {
    double *turn = out[i];
    turn[1] = middle[i];
    turn[0] = angle_between(n, on_circle(&c, middle[i]), to);
    km_vec3 x = km_vec3_perpendicular(h[2].axis), y = km_rotate(&G->R, x);
    y = has_rotation(h[1].axis, -turn[1], has_rotation(h[0].axis, -turn[0], y));
    turn[2] = angle_between(h[2].axis, x, y);
  }
  return count;
}

/* Adds the solutions of the group for given angles of a, b and c: G = A⁻¹ T B⁻¹. */
static int add_solutions(const km_six_hinges *six, const km_pose *T, const int index[3], const double outer_angles[3],
                         double (*angles)[KM_SIX], int count) {
  double group[2][3];
  km_pose G = *T; /* G = A⁻¹ T B⁻¹ */
  for (int k = 0; k < six->first; ++k) {
    km_pose back = motion(&six->hinges[k], -outer_angles[KM_SIX - six->first - 3 + k]);
    G = km_pose_product(&back, &G);
  }
  for (int k = KM_SIX - 1; k >= six->first + 3; --k) {
    km_pose back = motion(&six->hinges[k], -outer_angles[k - six->first - 3]);
    G = km_pose_product(&G, &back);
  }
  int group_count = solve_group(six, &G, group);
  for (int i = 0; i < group_count && count < KM_SIX_MAX_SOLUTIONS; ++i, ++count) {
    for (int k = 0; k < 3; ++k) {
      angles[count][index[k]] = outer_angles[k];
      angles[count][six->first + k] = group[i][k];
    }
  }
  return count;
}

/* Solves the equations of the outer hinges for pairs of angles, then the group for each pair. */
int km_six_hinges_solve(const km_six_hinges *six, const km_pose *target, double (*angles)[KM_SIX]) {
  km_pose back = km_pose_inverse(&six->effector), T = km_pose_product(target, &back);
  int index[3], count = 0;
  double equations[2][5], pairs[KM_MAX_PAIRS][2];
  outer_hinges s = outer_hinges_of(six, &T, index);
  if (six->group == KM_GROUP_CONCURRENT)
    equations_concurrent(six, &T, &s, equations);
  else
    equations_parallel(six, &T, &s, equations);
  int found = km_solve_cos_sin_pair(equations, pairs);
  for (int i = 0; i < found; ++i) {
    km_vec3 u = on_circle(&s.u, pairs[i][0]), w = on_circle(&s.w, pairs[i][1]);
    const double outer_angles[3] = {pairs[i][0], angle_between(s.b.axis, w, u), pairs[i][1]};
    count = add_solutions(six, &T, index, outer_angles, angles, count);
  }
  return found < 0 ? -1 : count;
}

/* Tolerance of a group: its approximate solutions are corrected by Newton's method. */
static const double group_tolerance = 1e-5;
/* Least sine of the angle between axes, and least distance of parallel axes: below it the equations are
 * ill-conditioned. */
static const double min_sine = 1e-4;

/* True if the three axes of the group meet in one point, which is stored as its centre. */
static bool is_concurrent(km_six_hinges *six) {
  const km_hinge *h = six->hinges + six->first;
  km_vec3 n = km_vec3_cross(h[0].axis, h[1].axis);
  double sine = km_vec3_norm(n);
  if (sine < min_sine || km_vec3_norm(km_vec3_cross(h[1].axis, h[2].axis)) < min_sine)
    return false;
  /* Point of the middle axis closest to the first axis. */
  km_vec3 apart = km_vec3_sub(h[0].point, h[1].point), toward = km_vec3_cross(h[0].axis, n);
  double along = km_vec3_dot(apart, toward) / km_vec3_dot(h[1].axis, toward);
  six->centre = km_vec3_axpy(along, h[1].axis, h[1].point);
  six->group = KM_GROUP_CONCURRENT;
  return km_vec3_norm(perpendicular_part(h[0].axis, km_vec3_sub(six->centre, h[0].point))) < group_tolerance &&
         km_vec3_norm(perpendicular_part(h[2].axis, km_vec3_sub(six->centre, h[2].point))) < group_tolerance;
}

/* True if the three axes of the group are parallel and distinct. */
static bool is_parallel(km_six_hinges *six) {
  const km_hinge *h = six->hinges + six->first;
  six->group = KM_GROUP_PARALLEL;
  for (int k = 0; k < 2; ++k)
    if (km_vec3_norm(km_vec3_cross(h[k].axis, h[k + 1].axis)) > group_tolerance ||
        km_vec3_norm(perpendicular_part(h[0].axis, km_vec3_sub(h[k + 1].point, h[k].point))) < min_sine)
      return false;
  return true;
}

bool km_six_hinges_find(const km_arm *a, km_arm_space *s, const double *q, int fixed, km_six_hinges *out) {
  *out = (km_six_hinges){.group = KM_GROUP_NONE};
  if (a->rows != KM_ARM_ROWS || a->n != KM_SIX + (fixed >= 0))
    return false;
  km_arm_update(a, s, q);
  out->effector = s->pose;
  for (int k = 0, i = 0; k < a->n; ++k) {
    if (k == fixed)
      continue;
    if (a->motions[k].primitive != KM_REVOLUTE)
      return false;
    const double *J = s->jacobian + k * a->rows;
    km_vec3 v = km_vec3_from_array(J), w = km_vec3_from_array(J + 3); /* v = w × (effector − point) */
    out->hinges[i] = (km_hinge){w, km_vec3_sub(s->pose.p, km_vec3_cross(v, w))};
    out->column[i++] = k;
  }
  for (out->first = 0; out->first <= KM_SIX - 3; ++out->first)
    if (is_concurrent(out) || is_parallel(out))
      return true;
  return false;
}
