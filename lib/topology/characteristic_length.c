/* Characteristic length of a model that states none: its longest link (docs/theory.md 1.4). */
#include "base/number/tolerances.h"
#include "base/number/union_find.h"
#include "topology/compile.h"

#include "base/extrema.h"

/* Union-find of bodies connected by rigid joints, in parent[body]. */
static void unite_rigid_bodies(const km_model *model, int *parent) {
  km_sets_reset(parent, model->body_count);
  for (int j = 0; j < model->joint_count; ++j)
    if (model->joints[j].type == KM_RIGID)
      parent[km_set_root(parent, km_joint_body(model, j, 0))] = km_set_root(parent, km_joint_body(model, j, 1));
}

/* Rounding length of positions: 1e-14 of the largest coordinate. */
double km_position_rounding(const km_model *model) {
  double square = 0.0;
  for (int f = 0; f < model->frame_count; ++f)
    square = km_larger(km_vec3_dot(model->frames[f].pose.p, model->frames[f].pose.p), square);
  return km_sum_rounding * sqrt(square);
}

/* Squared distance of two positions; 0 below their rounding. */
double km_squared_distance(km_vec3 a, km_vec3 b, double rounding_length) {
  km_vec3 offset = km_vec3_sub(a, b);
  double square = km_vec3_dot(offset, offset), sizes = km_vec3_dot(a, a) + km_vec3_dot(b, b);
  return square > rounding_length * rounding_length && square > km_relative_zero * km_relative_zero * sizes ? square
                                                                                                            : 0.0;
}

/* Position of a joint on a body, one of the two that it connects. */
static km_vec3 joint_position(const km_model *model, int joint, int body) {
  int end = km_joint_body(model, joint, 0) != body;
  return model->frames[model->joints[joint].frame[end]].pose.p;
}

/* Longest link over all moving bodies. */
double km_longest_link(const km_mechanism *m, int *parent) {
  const km_model *model = m->model;
  const km_topology *t = &m->topology;
  double longest = 0.0;
  unite_rigid_bodies(model, parent);
  for (int b = 1; b < model->body_count; ++b)
    for (int i = t->incident_start[b]; i < t->incident_start[b + 1] && km_set_root(parent, b) != km_set_root(parent, 0);
         ++i)
      for (int k = t->incident_start[b]; k < i; ++k)
        longest = km_larger(km_squared_distance(joint_position(model, t->incident[i], b),
                                                joint_position(model, t->incident[k], b), m->position_rounding),
                            longest);
  return sqrt(longest);
}
