/* Which components of reactions statics alone doesn't determine: those in which some self-stress has a part. Two random
 * ones are looked at side by side; both miss a component with a chance of 1e-18. */
#include "base/random.h"
#include "statics/statics.h"

#include <string.h>

/* Vectors and wrenches of both. */
typedef struct pair3 {
  km_pair x, y, z;
} pair3;

static pair3 add(km_pair s, const km_pair *a, pair3 b) { /* s a + b */
  return (pair3){s * a[0] + b.x, s * a[1] + b.y, s * a[2] + b.z};
}
static pair3 cross(km_vec3 a, pair3 b) {
  return (pair3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static void turn_back(const km_rotation *R, pair3 a, km_pair out[3]) {
  for (int k = 0; k < 3; ++k)
    out[k] = R->axis[k].x * a.x + R->axis[k].y * a.y + R->axis[k].z * a.z;
}
static km_pair size_of(km_pair a) {
  return km_pair_and(a, (km_pair)(km_bits){KM_MAGNITUDE, KM_MAGNITUDE});
}

/* The same numbers at every pose. */
static void draw(int degree, km_pair *share) {
  uint64_t random = 1;
  for (int k = 0; k < degree; ++k)
    for (int look = 0; look < 2; ++look)
      share[k][look] = km_uniform(&random);
}

/* parts[6 · joints]: what both do in the joints, along the reactions' axes. */
static void mark(const km_reaction_workspace *c, const km_pair *parts, km_reaction *reactions) {
  km_pair force = {0.0, 0.0}, torque = {0.0, 0.0};
  for (int j = 0; j < c->joints; ++j)
    for (int k = 0; k < 3; ++k) {
      force = km_pair_larger(size_of(parts[6 * j + k]), force);
      torque = km_pair_larger(size_of(parts[6 * j + 3 + k]), torque);
    }
  km_pair least[2];
  least[0] = km_no_part * km_pair_larger(force, torque / c->size);
  least[1] = least[0] * c->size;
  for (int j = 0; j < c->joints; ++j) {
    bool *indeterminate = reactions[c->joint[j]].indeterminate;
    for (int k = 0; k < 6; ++k) {
      km_bits over = (km_bits)(size_of(parts[6 * j + k]) > least[k / 3]);
      indeterminate[k] = (over[0] | over[1]) != 0;
    }
  }
}

/* L⁻ᵀ r: of these none outweighs the others. */
static void weigh(const km_reaction_workspace *c, int degree, km_pair *share) {
  size_t n = (size_t)degree;
  for (size_t k = n; k-- > 0;) {
    const double *l = c->gram + k * n;
    for (size_t r = k + 1; r < n; ++r)
      share[k] -= l[r] * share[r];
    share[k] *= l[k];
  }
}

/* What both do in a joint. */
static void look_at_joint(const km_reaction_workspace *c, const km_rotation *R, int j, const km_pair *chords,
                          km_pair *parts) {
  pair3 f = {{0}, {0}, {0}}, t = f;
  for (int i = c->first[j]; i < c->first[j + 1]; ++i) {
    const km_pair *chord = chords + 6 * c->passing[i].loop;
    km_pair sense = {c->passing[i].sense, c->passing[i].sense};
    f = add(sense, chord, f);
    t = add(sense, chord + 3, t);
  }
  double inverse = 1.0 / c->size;
  f = (pair3){inverse * f.x, inverse * f.y, inverse * f.z};
  pair3 moved = cross(c->arm[j], f);
  turn_back(R, f, parts);
  turn_back(R, (pair3){t.x - moved.x, t.y - moved.y, t.z - moved.z}, parts + 3);
}

void km_indeterminate_components_mark(km_reaction_workspace *c, const km_statics_workspace *w, km_reaction *reactions) {
  km_pair *share = c->looks, *chords = share + c->rows, *parts = chords + c->rows;
  draw(c->degree, share);
  weigh(c, c->degree, share);
  memset(chords, 0, (size_t)c->rows * sizeof *chords);
  for (int k = 0; k < c->degree; ++k)
    for (int i = c->stress_start[k]; i < c->stress_start[k + 1]; ++i)
      chords[c->stress[i].row] += c->stress[i].value * share[k];
  for (int j = 0; j < c->joints; ++j)
    look_at_joint(c, &w->frame[c->joint[j]].R, j, chords, parts + 6 * j);
  mark(c, parts, reactions);
}
