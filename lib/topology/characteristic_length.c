/* Characteristic length of a model that states none: its longest link (docs/theory.md 1.4). */
#include "base/number/tolerances.h"
#include "base/number/union_find.h"
#include "topology/compile.h"

#include "base/extrema.h"

#include <string.h>

/* Union-find of bodies connected by rigid joints, in parent[body]. */
static void unite_rigid_bodies(const km_model *model, int *parent) {
  km_sets_create(parent, model->body_count);
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_joint *def = &model->joints[j];
    if (def->type == KM_RIGID)
      parent[km_set_of(parent, model->frames[def->frame[0]].body)] =
          km_set_of(parent, model->frames[def->frame[1]].body);
  }
}

/* Sorts the joints' frames by body: those of body b are frame[first[b]] … frame[first[b + 1] - 1]. */
static void sort_frames_by_body(const km_model *model, int *first, int *frame) {
  for (int j = 0; j < model->joint_count; ++j)
    for (int e = 0; e < 2; ++e)
      first[km_joint_body(model, j, e) + 2]++;
  for (int b = 0; b < model->body_count; ++b)
    first[b + 2] += first[b + 1];
  /* first[b + 1] is the index of the next frame of body b; in the end it is the first index of body b + 1. */
  for (int j = 0; j < model->joint_count; ++j)
    for (int e = 0; e < 2; ++e)
      frame[first[km_joint_body(model, j, e) + 1]++] = model->joints[j].frame[e];
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

/* Longest link over all moving bodies. */
double km_longest_link(const km_model *model, const km_compile_workspace *workspace, double rounding_length) {
  int *parent = workspace->parent, *first = workspace->first, *frame = workspace->frame;
  double longest = 0.0;
  memset(first, 0, ((size_t)model->body_count + 2) * sizeof *first);
  unite_rigid_bodies(model, parent);
  sort_frames_by_body(model, first, frame);
  for (int b = 1; b < model->body_count; ++b)
    for (int i = first[b]; i < first[b + 1] && km_set_of(parent, b) != km_set_of(parent, 0); ++i)
      for (int k = first[b]; k < i; ++k)
        longest = km_larger(
            km_squared_distance(model->frames[frame[i]].pose.p, model->frames[frame[k]].pose.p, rounding_length),
            longest);
  return sqrt(longest);
}
