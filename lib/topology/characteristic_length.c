/* The characteristic length of a model that states none: its longest link. */
#include "topology/compile.h"

#include "base/extrema.h"

#include <string.h>

/* The representative of a body among those that rigid joints tie together. */
static int find(int *parent, int body) {
  while (parent[body] != body) {
    parent[body] = parent[parent[body]];
    body = parent[body];
  }
  return body;
}

/* parent[body]: bodies tied to the inertial frame by rigid joints alone have its representative. */
static void tie_rigid(const km_model *model, int *parent) {
  for (int b = 0; b < model->body_count; ++b)
    parent[b] = b;
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_joint *def = &model->joints[j];
    if (def->type == KM_RIGID)
      parent[find(parent, model->frames[def->frame[0]].body)] = find(parent, model->frames[def->frame[1]].body);
  }
}

/* Sorts the joints' frames by body: those of body b are frame[first[b]] … frame[first[b + 1] - 1]. */
static void sort_frames(const km_model *model, int *first, int *frame) {
  for (int j = 0; j < model->joint_count; ++j)
    for (int e = 0; e < 2; ++e)
      first[model->frames[model->joints[j].frame[e]].body + 2]++;
  for (int b = 0; b < model->body_count; ++b)
    first[b + 2] += first[b + 1];
  /* first[b + 1] is where the next frame of body b goes, and ends up where the body's frames end. */
  for (int j = 0; j < model->joint_count; ++j)
    for (int e = 0; e < 2; ++e)
      frame[first[model->frames[model->joints[j].frame[e]].body + 1]++] = model->joints[j].frame[e];
}

double km_position_rounding(const km_model *model) {
  static const double rounding = 1e-14; /* of the largest coordinate */
  double square = 0.0;
  for (int f = 0; f < model->frame_count; ++f)
    square = km_larger(km_vec3_dot(model->frames[f].pose.p, model->frames[f].pose.p), square);
  return rounding * sqrt(square);
}

double km_squared_distance(km_vec3 a, km_vec3 b, double grain) {
  static const double rounding = 1e-10; /* of the places */
  km_vec3 way = km_vec3_sub(a, b);
  double square = km_vec3_dot(way, way), sizes = km_vec3_dot(a, a) + km_vec3_dot(b, b);
  return square > grain * grain && square > rounding * rounding * sizes ? square : 0.0;
}

double km_longest_link(const km_model *model, const km_compile_workspace *walks, double grain) {
  int *parent = walks->parent, *first = walks->first, *frame = walks->frame;
  double longest = 0.0;
  memset(first, 0, ((size_t)model->body_count + 2) * sizeof *first);
  tie_rigid(model, parent);
  sort_frames(model, first, frame);
  for (int b = 1; b < model->body_count; ++b)
    for (int i = first[b]; i < first[b + 1] && find(parent, b) != find(parent, 0); ++i)
      for (int k = first[b]; k < i; ++k)
        longest = km_larger(km_squared_distance(model->frames[frame[i]].pose.p, model->frames[frame[k]].pose.p, grain),
                            longest);
  return sqrt(longest);
}
