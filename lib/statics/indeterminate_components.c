/* Indeterminate components of reactions (theory 9.5): those in which a self-stress has a part. Two random
 * self-stresses are evaluated in SIMD pairs; both miss a component with probability 1e-18. */
#include "base/random.h"
#include "statics/statics.h"

#include <string.h>

/* A vector of both self-stresses. */
typedef struct pair3 {
  km_pair x, y, z;
} pair3;

static pair3 add(km_pair s, const km_pair *a, pair3 b) { /* s a + b */
  return (pair3){s * a[0] + b.x, s * a[1] + b.y, s * a[2] + b.z};
}
static pair3 cross(km_vec3 a, pair3 b) {
  return (pair3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static void rotate_back(const km_rotation *R, pair3 a, km_pair out[3]) {
  for (int k = 0; k < 3; ++k)
    out[k] = R->axis[k].x * a.x + R->axis[k].y * a.y + R->axis[k].z * a.z;
}
static km_pair magnitude(km_pair a) {
  return km_pair_and(a, (km_pair)(km_bits){KM_MAGNITUDE, KM_MAGNITUDE});
}

/* Draws random coefficients, equal at every configuration. */
static void draw_coefficients(int degree, km_pair *coefficients) {
  uint64_t random = 1;
  for (int k = 0; k < degree; ++k)
    for (int sample = 0; sample < 2; ++sample)
      coefficients[k][sample] = km_uniform(&random);
}

/* Marks the components above rounding. parts[6 · joints]: both self-stresses along the reactions' axes. */
static void mark_components(const km_reaction_workspace *c, const km_pair *parts, km_reaction *reactions) {
  km_pair force = {0.0, 0.0}, torque = {0.0, 0.0};
  for (int j = 0; j < c->joints; ++j)
    for (int k = 0; k < 3; ++k) {
      force = km_pair_larger(magnitude(parts[6 * j + k]), force);
      torque = km_pair_larger(magnitude(parts[6 * j + 3 + k]), torque);
    }
  km_pair threshold[2];
  threshold[0] = km_relative_zero * km_pair_larger(force, torque / c->size);
  threshold[1] = threshold[0] * c->size;
  for (int j = 0; j < c->joints; ++j) {
    bool *indeterminate = reactions[c->joint[j]].indeterminate;
    for (int k = 0; k < 6; ++k) {
      km_bits is_above = (km_bits)(magnitude(parts[6 * j + k]) > threshold[k / 3]);
      indeterminate[k] = (is_above[0] | is_above[1]) != 0;
    }
  }
}

/* Computes L⁻ᵀ r, L Lᵀ the Gram matrix of the self-stresses, so that no self-stress dominates. */
static void whiten_coefficients(const km_reaction_workspace *c, int degree, km_pair *coefficients) {
  size_t n = (size_t)degree;
  for (size_t k = n; k-- > 0;) {
    const double *l = c->gram + k * n;
    for (size_t r = k + 1; r < n; ++r)
      coefficients[k] -= l[r] * coefficients[r];
    coefficients[k] *= l[k];
  }
}

/* Computes both self-stresses' wrenches in a joint. */
static void compute_in_joint(const km_reaction_workspace *c, const km_rotation *R, int j, const km_pair *chords,
                             km_pair *parts) {
  pair3 f = {{0}, {0}, {0}}, t = f;
  int joint = c->joint[j];
  for (int i = c->first[joint]; i < c->first[joint + 1]; ++i) {
    const km_pair *chord = chords + 6 * c->joint_loops[i].loop;
    km_pair sign = {c->joint_loops[i].sign, c->joint_loops[i].sign};
    f = add(sign, chord, f);
    t = add(sign, chord + 3, t);
  }
  double inverse = 1.0 / c->size;
  f = (pair3){inverse * f.x, inverse * f.y, inverse * f.z};
  pair3 moved = cross(c->arm[j], f);
  rotate_back(R, f, parts);
  rotate_back(R, (pair3){t.x - moved.x, t.y - moved.y, t.z - moved.z}, parts + 3);
}

/* Evaluates two random combinations of the self-stresses in every joint, and marks the reaction components in which one
 * of them is not zero. */
void km_indeterminate_components_mark(km_reaction_workspace *c, const km_statics_workspace *w, km_reaction *reactions) {
  km_pair *coefficients = c->sample, *chords = coefficients + c->rows, *parts = chords + c->rows;
  draw_coefficients(c->degree, coefficients);
  whiten_coefficients(c, c->degree, coefficients);
  memset(chords, 0, (size_t)c->rows * sizeof *chords);
  for (int k = 0; k < c->degree; ++k)
    for (int i = c->stress_start[k]; i < c->stress_start[k + 1]; ++i)
      chords[c->stress[i].row] += c->stress[i].value * coefficients[k];
  for (int j = 0; j < c->joints; ++j)
    compute_in_joint(c, &w->frame[c->joint[j]].R, j, chords, parts + 6 * j);
  mark_components(c, parts, reactions);
}
