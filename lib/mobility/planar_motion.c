/* Planar motion: a mechanism or loop moves in parallel planes if all its hinges are parallel to one normal and all
 * its slides orthogonal to it (theory 2.5). */
#include "base/number/tolerances.h"
#include "kmech/mechanism.h"

#include "kinematics/body_poses.h"
#include "kinematics/state.h"

/* The free coordinates of a loop, or of the whole mechanism (-1), at the state's configuration. */
typedef struct coordinate_set {
  const km_mechanism *m;
  const km_state *s;
  int loop;
} coordinate_set;

typedef struct cursor {
  int member, k; /* next joint, and its next coordinate */
} cursor;

static int member_count(const coordinate_set *a) {
  const km_topology *t = &a->m->topology;
  return a->loop < 0 ? a->m->model->joint_count : t->member_start[a->loop + 1] - t->member_start[a->loop];
}

static int joint_at(const coordinate_set *a, int member) {
  const km_topology *t = &a->m->topology;
  return a->loop < 0 ? member : t->member[t->member_start[a->loop] + member].joint;
}

/* Returns the next coordinate's twist; false after the last one. */
static bool next_twist(const coordinate_set *a, cursor *at, km_twist *out) {
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

/* Finds the normal: the first hinge's axis, else the cross product of two slides; false without either. */
static bool find_normal(const coordinate_set *a, km_vec3 *normal) {
  km_vec3 translation = {0, 0, 0};
  km_twist t;
  for (cursor at = {0, 0}; next_twist(a, &at, &t);)
    if (km_vec3_norm(t.w) > 0.0) {
      *normal = km_vec3_scale(1.0 / km_vec3_norm(t.w), t.w);
      return true;
    }
  for (cursor at = {0, 0}; next_twist(a, &at, &t);) {
    km_vec3 across = km_vec3_cross(translation, t.v);
    double size = km_vec3_norm(across);
    if (size > km_relative_zero * km_vec3_norm(t.v)) {
      *normal = km_vec3_scale(1.0 / size, across);
      return true;
    }
    translation = km_vec3_scale(1.0 / km_vec3_norm(t.v), t.v);
  }
  return false;
}

/* True if the twist is a rotation about the normal or a translation orthogonal to it; a screw is neither. The
 * rounding of v = p × ω grows with p. */
static bool is_planar_twist(km_twist t, km_vec3 n) {
  double rotation = km_vec3_norm(t.w), translation = km_vec3_norm(t.v);
  return km_vec3_norm(km_vec3_cross(t.w, n)) <= km_relative_zero * rotation &&
         fabs(km_vec3_dot(t.v, n)) <= km_relative_zero * translation;
}

/* Writes the normal with the sign that makes its largest component positive. */
static void write_normal(km_vec3 n, double out[3]) {
  double largest = n.x;
  if (fabs(n.y) > fabs(largest) * (1.0 + km_relative_zero))
    largest = n.y;
  if (fabs(n.z) > fabs(largest) * (1.0 + km_relative_zero))
    largest = n.z;
  km_vec3 v = km_vec3_scale(largest < 0.0 ? -1.0 : 1.0, n);
  out[0] = v.x + 0.0;
  out[1] = v.y + 0.0;
  out[2] = v.z + 0.0;
}

static bool find_plane(const coordinate_set *a, double normal[3]) {
  km_vec3 n;
  km_twist t;
  if (!find_normal(a, &n))
    return false;
  for (cursor at = {0, 0}; next_twist(a, &at, &t);)
    if (!is_planar_twist(t, n))
      return false;
  write_normal(n, normal);
  return true;
}

bool km_mechanism_plane(const km_mechanism *m, const km_state *s, double normal[3]) {
  return km_state_belongs_to(m, s) && normal && find_plane(&(coordinate_set){m, s, -1}, normal);
}

bool km_loop_plane(const km_mechanism *m, const km_state *s, int loop, double normal[3]) {
  return km_state_belongs_to(m, s) && normal && loop >= 0 && loop < m->topology.loop_count &&
         find_plane(&(coordinate_set){m, s, loop}, normal);
}
