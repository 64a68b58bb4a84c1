/* Closed-form inverse kinematics of six hinges with a group of three that meet or are parallel.
 *
 * The product of turns T = e₁ … e₆ is given. Hinges i, i + 1, i + 2 make the group G, the others are A before and B
 * after it: G⁻¹ = B T⁻¹ A, and so Ra Rb Rc = T G⁻¹ with a, b, c the hinges of B, moved by T, and then those of A.
 *
 *   Meeting:  G leaves the centre c where it is:   Ra Rb Rc c = T c.
 *   Parallel: G keeps the direction d, and the place along it:   Ra Rb Rc d = T d,  d · (G⁻¹ o − o) = 0.
 *
 * With u = Ra⁻¹(right side) and w = Rc(left side), both on circles, Rb w = u asks that w and u are at the same height
 * along b; and at the same distance from a point of b (meeting), or that the places along d agree (parallel). These are
 * two equations that are linear in (cos a, sin a) and (cos c, sin c) together: up to four solutions. Rb is the turn
 * from w to u, and the group's own turns follow with two solutions each. */
#include "arm/ik/six_revolute_ik.h"

#include "arm/ik/trigonometric_equations.h"

#include <string.h>

static km_rotation turn_about(km_vec3 axis, double angle) {
  return km_quaternion_rotation(km_quaternion_exp(km_vec3_scale(angle, axis)));
}

static km_vec3 turned(km_vec3 axis, double angle, km_vec3 x) {
  km_rotation R = turn_about(axis, angle);
  return km_rotate(&R, x);
}

static km_pose motion(const km_hinge *h, double angle) {
  km_pose pose = {turn_about(h->axis, angle), {0, 0, 0}};
  pose.p = km_vec3_sub(h->point, km_rotate(&pose.R, h->point));
  return pose;
}

static km_vec3 across(km_vec3 axis, km_vec3 x) {
  return km_vec3_axpy(-km_vec3_dot(axis, x), axis, x);
}

/* The turn about an axis that brings one direction to another; 0 if one lies along the axis. */
static double turn_between(km_vec3 axis, km_vec3 from, km_vec3 to) {
  km_vec3 a = across(axis, from), b = across(axis, to);
  return atan2(km_vec3_dot(axis, km_vec3_cross(a, b)), km_vec3_dot(a, b));
}

/* A direction x turned about an axis by ±θ: still + cos θ · cosine + sin θ · sine. */
typedef struct circle {
  km_vec3 still, cosine, sine;
} circle;

static circle circle_of(km_vec3 axis, km_vec3 x, double sense) {
  km_vec3 cosine = across(axis, x);
  return (circle){km_vec3_sub(x, cosine), cosine, km_vec3_scale(sense, km_vec3_cross(axis, x))};
}

static km_vec3 on_circle(const circle *c, double angle) {
  return km_vec3_axpy(sin(angle), c->sine, km_vec3_axpy(cos(angle), c->cosine, c->still));
}

/* The three hinges beside the group, in the order of the closed loop, and what they bring where. */
typedef struct beside {
  km_hinge a, b, c;
  circle u, w;
  km_vec3 origin; /* that Rb turns u and w about */
} beside;

/* out[5]: what is multiplied by cos a, sin a, cos c, sin c, and what is added, in f · (u − w). */
static void add_height(const beside *s, km_vec3 f, km_vec3 g, double constant, double *out) {
  out[0] = km_vec3_dot(f, s->u.cosine);
  out[1] = km_vec3_dot(f, s->u.sine);
  out[2] = km_vec3_dot(g, s->w.cosine);
  out[3] = km_vec3_dot(g, s->w.sine);
  out[4] = km_vec3_dot(f, s->u.still) + km_vec3_dot(g, s->w.still) + constant;
}

static double square(km_vec3 a) {
  return km_vec3_dot(a, a);
}

/* u and w are seen from a point of b. */
static void equations_meeting(const km_six_hinges *six, const km_pose *T, beside *s, double out[2][5]) {
  km_vec3 to = km_pose_point(T, six->centre);
  s->origin = s->b.point;
  s->u = circle_of(s->a.axis, km_vec3_sub(to, s->a.point), -1.0);
  s->w = circle_of(s->c.axis, km_vec3_sub(six->centre, s->c.point), 1.0);
  s->u.still = km_vec3_add(s->u.still, km_vec3_sub(s->a.point, s->origin));
  s->w.still = km_vec3_add(s->w.still, km_vec3_sub(s->c.point, s->origin));
  add_height(s, s->b.axis, km_vec3_scale(-1.0, s->b.axis), 0.0, out[0]);
  /* |u|² = |still|² + |cosine|² + 2 still · (cos cosine + sin sine) */
  out[1][0] = 2.0 * km_vec3_dot(s->u.still, s->u.cosine);
  out[1][1] = 2.0 * km_vec3_dot(s->u.still, s->u.sine);
  out[1][2] = -2.0 * km_vec3_dot(s->w.still, s->w.cosine);
  out[1][3] = -2.0 * km_vec3_dot(s->w.still, s->w.sine);
  out[1][4] = square(s->u.still) + square(s->u.cosine) - square(s->w.still) - square(s->w.cosine);
}

static void equations_parallel(const km_six_hinges *six, const km_pose *T, beside *s, double out[2][5]) {
  km_vec3 d = six->hinges[six->first].axis, to = km_rotate(&T->R, d);
  s->u = circle_of(s->a.axis, to, -1.0);
  s->w = circle_of(s->c.axis, d, 1.0);
  s->origin = (km_vec3){0, 0, 0};
  add_height(s, s->b.axis, km_vec3_scale(-1.0, s->b.axis), 0.0, out[0]);
  double constant = km_vec3_dot(to, km_vec3_sub(s->a.point, T->p)) - km_vec3_dot(d, s->c.point);
  add_height(s, km_vec3_sub(s->b.point, s->a.point), km_vec3_sub(s->c.point, s->b.point), constant, out[1]);
}

static beside sides_of(const km_six_hinges *six, const km_pose *T, int index[3]) {
  km_hinge order[3];
  for (int k = 0; k < 3; ++k) {
    index[k] = (six->first + 3 + k) % KM_SIX;
    order[k] = six->hinges[index[k]];
    if (six->first + 3 + k < KM_SIX) {
      order[k].point = km_pose_point(T, order[k].point);
      order[k].axis = km_rotate(&T->R, order[k].axis);
    }
  }
  return (beside){.a = order[0], .b = order[1], .c = order[2]};
}

/* The group's own turns for G. */
static int solve_group(const km_six_hinges *six, const km_pose *G, double (*out)[3]) {
  const km_hinge *h = six->hinges + six->first;
  km_vec3 n = h[0].axis, from, to; /* e₁e₂ brings from to to */
  double line[3], middle[2];
  circle c;
  if (six->group == KM_GROUP_MEETING) {
    from = h[2].axis;
    to = km_rotate(&G->R, from);
    c = circle_of(h[1].axis, from, 1.0);
    line[0] = km_vec3_dot(n, c.cosine);
    line[1] = km_vec3_dot(n, c.sine);
    line[2] = km_vec3_dot(n, c.still) - km_vec3_dot(n, to);
  } else {
    from = km_vec3_sub(h[2].point, h[1].point);
    to = across(n, km_vec3_sub(km_pose_point(G, h[2].point), h[0].point));
    c = circle_of(h[1].axis, from, 1.0);
    c.still = km_vec3_add(c.still, km_vec3_sub(h[1].point, h[0].point));
    c.still = across(n, c.still);
    line[0] = 2.0 * km_vec3_dot(c.still, c.cosine);
    line[1] = 2.0 * km_vec3_dot(c.still, c.sine);
    line[2] = square(c.still) + square(c.cosine) - square(to);
  }
  int count = km_solve_line(line, middle);
  for (int i = 0; i < count; ++i) {
    double *turn = out[i];
    turn[1] = middle[i];
    turn[0] = turn_between(n, on_circle(&c, middle[i]), to);
    km_vec3 x = km_vec3_perpendicular(h[2].axis), y = km_rotate(&G->R, x);
    y = turned(h[1].axis, -turn[1], turned(h[0].axis, -turn[0], y));
    turn[2] = turn_between(h[2].axis, x, y);
  }
  return count;
}

/* With a, b and c known: the group is what they leave. */
static int add_solutions(const km_six_hinges *six, const km_pose *T, const int index[3], const double three[3],
                         double (*turns)[KM_SIX], int count) {
  double group[2][3];
  km_pose G = *T; /* G = A⁻¹ T B⁻¹ */
  for (int k = 0; k < six->first; ++k) {
    km_pose back = motion(&six->hinges[k], -three[KM_SIX - six->first - 3 + k]);
    G = km_pose_product(&back, &G);
  }
  for (int k = KM_SIX - 1; k >= six->first + 3; --k) {
    km_pose back = motion(&six->hinges[k], -three[k - six->first - 3]);
    G = km_pose_product(&G, &back);
  }
  int ways = solve_group(six, &G, group);
  for (int i = 0; i < ways && count < KM_SIX_MOST; ++i, ++count) {
    for (int k = 0; k < 3; ++k) {
      turns[count][index[k]] = three[k];
      turns[count][six->first + k] = group[i][k];
    }
  }
  return count;
}

int km_six_hinges_solve(const km_six_hinges *six, const km_pose *target, double (*turns)[KM_SIX]) {
  km_pose back = km_pose_inverse(&six->hand), T = km_pose_product(target, &back);
  int index[3], count = 0;
  double equations[2][5], pairs[KM_PAIRS_MOST][2];
  beside s = sides_of(six, &T, index);
  if (six->group == KM_GROUP_MEETING)
    equations_meeting(six, &T, &s, equations);
  else
    equations_parallel(six, &T, &s, equations);
  int found = km_solve_pair(equations, pairs);
  for (int i = 0; i < found; ++i) {
    km_vec3 u = on_circle(&s.u, pairs[i][0]), w = on_circle(&s.w, pairs[i][1]);
    const double three[3] = {pairs[i][0], turn_between(s.b.axis, w, u), pairs[i][1]};
    count = add_solutions(six, &T, index, three, turns, count);
  }
  return found < 0 ? -1 : count;
}

/* Axes that are nearly in a group lead to nearly the right poses, from which Newton's method comes to them. */
static const double slack = 1e-5;
/* Axes that are nearly one line, or directions that are nearly one, determine next to nothing. */
static const double least = 1e-4;

static bool meets(km_six_hinges *six) {
  const km_hinge *h = six->hinges + six->first;
  km_vec3 n = km_vec3_cross(h[0].axis, h[1].axis);
  double sine = km_vec3_norm(n);
  if (sine < least || km_vec3_norm(km_vec3_cross(h[1].axis, h[2].axis)) < least)
    return false;
  /* The point of the middle axis that is nearest to the first one. */
  km_vec3 apart = km_vec3_sub(h[0].point, h[1].point), toward = km_vec3_cross(h[0].axis, n);
  double along = km_vec3_dot(apart, toward) / km_vec3_dot(h[1].axis, toward);
  six->centre = km_vec3_axpy(along, h[1].axis, h[1].point);
  six->group = KM_GROUP_MEETING;
  return km_vec3_norm(across(h[0].axis, km_vec3_sub(six->centre, h[0].point))) < slack &&
         km_vec3_norm(across(h[2].axis, km_vec3_sub(six->centre, h[2].point))) < slack;
}

static bool is_parallel(km_six_hinges *six) {
  const km_hinge *h = six->hinges + six->first;
  six->group = KM_GROUP_PARALLEL;
  for (int k = 0; k < 2; ++k)
    if (km_vec3_norm(km_vec3_cross(h[k].axis, h[k + 1].axis)) > slack ||
        km_vec3_norm(across(h[0].axis, km_vec3_sub(h[k + 1].point, h[k].point))) < least)
      return false;
  return true;
}

bool km_six_hinges_find(const km_arm *a, km_arm_space *s, const double *q, int held, km_six_hinges *out) {
  *out = (km_six_hinges){.group = KM_GROUP_NONE};
  if (a->rows != KM_ARM_ROWS || a->n != KM_SIX + (held >= 0))
    return false;
  km_arm_update(a, s, q);
  out->hand = s->pose;
  for (int k = 0, i = 0; k < a->n; ++k) {
    if (k == held)
      continue;
    if (a->motions[k].primitive != KM_REVOLUTE)
      return false;
    const double *J = s->jacobian + k * a->rows;
    km_vec3 v = km_vec3_from_array(J), w = km_vec3_from_array(J + 3); /* v = w × (hand − point) */
    out->hinges[i] = (km_hinge){w, km_vec3_sub(s->pose.p, km_vec3_cross(v, w))};
    out->column[i++] = k;
  }
  for (out->first = 0; out->first <= KM_SIX - 3; ++out->first)
    if (meets(out) || is_parallel(out))
      return true;
  return false;
}
