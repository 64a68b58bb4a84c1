/* Mechanisms and loops that move in parallel planes. */
#include "kmech/mechanism.h"

#include "kinematics/body_poses.h"
#include "kinematics/state.h"

static const double aligned = 1e-9; /* sine of the angle below which directions are parallel */

/* The free coordinates of a loop, or (-1) of the whole mechanism, at the state's poses. */
typedef struct axes {
  const km_mechanism *m;
  const km_state *s;
  int loop;
} axes;

typedef struct cursor {
  int member, k; /* the next joint, and its next coordinate */
} cursor;

static int member_count(const axes *a) {
  const km_topology *t = &a->m->topology;
  return a->loop < 0 ? a->m->model->joint_count : t->member_start[a->loop + 1] - t->member_start[a->loop];
}

static int joint_at(const axes *a, int member) {
  const km_topology *t = &a->m->topology;
  return a->loop < 0 ? member : t->member[t->member_start[a->loop] + member].joint;
}

/* The next twist; false behind the last one. */
static bool next(const axes *a, cursor *at, km_twist *out) {
  for (; at->member < member_count(a); ++at->member, at->k = 0) {
    const km_model_joint *joint = &a->m->model->joints[joint_at(a, at->member)];
    while (at->k < km_joint_kind_of(joint->type)->freedom) {
      int c = joint->first_coordinate + at->k++;
      if (a->m->held[c])
        continue;
      *out = km_coordinate_twist(a->m, a->s, c);
      return true;
    }
  }
  return false;
}

/* Across the first hinge, or else two slides; false where there are neither. */
static bool find_normal(const axes *a, km_vec3 *normal) {
  km_vec3 slide = {0, 0, 0};
  km_twist t;
  for (cursor at = {0, 0}; next(a, &at, &t);)
    if (km_vec3_norm(t.w) > 0.0) {
      *normal = km_vec3_scale(1.0 / km_vec3_norm(t.w), t.w);
      return true;
    }
  for (cursor at = {0, 0}; next(a, &at, &t);) {
    km_vec3 across = km_vec3_cross(slide, t.v);
    double size = km_vec3_norm(across);
    if (size > aligned * km_vec3_norm(t.v)) {
      *normal = km_vec3_scale(1.0 / size, across);
      return true;
    }
    slide = km_vec3_scale(1.0 / km_vec3_norm(t.v), t.v);
  }
  return false;
}

/* Turns about the normal, slides across it; a screw does neither alone. Rounding of v = p × w grows with p. */
static bool moves_across(km_twist t, km_vec3 n) {
  double turn = km_vec3_norm(t.w), slide = km_vec3_norm(t.v);
  return km_vec3_norm(km_vec3_cross(t.w, n)) <= aligned * turn && fabs(km_vec3_dot(t.v, n)) <= aligned * slide;
}

/* The sense in which the largest component is positive. */
static void write_out(km_vec3 n, double out[3]) {
  double largest = n.x;
  if (fabs(n.y) > fabs(largest) * (1.0 + aligned))
    largest = n.y;
  if (fabs(n.z) > fabs(largest) * (1.0 + aligned))
    largest = n.z;
  km_vec3 v = km_vec3_scale(largest < 0.0 ? -1.0 : 1.0, n);
  out[0] = v.x + 0.0;
  out[1] = v.y + 0.0;
  out[2] = v.z + 0.0;
}

static bool find(const axes *a, double normal[3]) {
  km_vec3 n;
  km_twist t;
  if (!find_normal(a, &n))
    return false;
  for (cursor at = {0, 0}; next(a, &at, &t);)
    if (!moves_across(t, n))
      return false;
  write_out(n, normal);
  return true;
}

bool km_mechanism_plane(const km_mechanism *m, const km_state *s, double normal[3]) {
  return km_state_belongs_to(m, s) && normal && find(&(axes){m, s, -1}, normal);
}

bool km_loop_plane(const km_mechanism *m, const km_state *s, int loop, double normal[3]) {
  return km_state_belongs_to(m, s) && normal && loop >= 0 && loop < m->topology.loop_count &&
         find(&(axes){m, s, loop}, normal);
}
