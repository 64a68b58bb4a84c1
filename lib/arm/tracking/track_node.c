/* One pose of a track: the directions that lead on from it, and how the steps that led to it bent. */
#include "arm/tracking/tracker.h"

#include <string.h>

/* Numbers of a node's arrays. */
static size_t node_size(const km_arm *a) {
  size_t n = (size_t)a->n, freedom = (size_t)a->freedom;
  return n + (n + 1) + freedom * n + KM_NODE_BENDS * n + freedom;
}

bool km_node_create(const km_arm *a, km_arena *arena, km_node *node) {
  size_t n = (size_t)a->n, freedom = (size_t)a->freedom;
  *node = (km_node){.q = KM_ARENA_NEW(arena, double, node_size(a))};
  if (!node->q)
    return false;
  node->path = node->q + n;
  node->self = node->path + n + 1;
  node->bend = node->self + freedom * n;
  node->tilt = node->bend + KM_NODE_BENDS * n;
  return true;
}

void km_node_copy(const km_arm *a, km_node *to, const km_node *from) {
  memcpy(to->q, from->q, node_size(a) * sizeof *to->q);
  to->along = from->along;
  to->bends = from->bends;
  to->z = from->z;
  to->value = from->value;
}

void km_node_rates(const km_arm *a, const double *path, const double *self, double speed, const double *mean,
                   double *rates) {
  const double scale = path[a->n] > 0.0 ? speed / path[a->n] : 0.0;
  for (int k = 0; k < a->n; ++k)
    rates[k] = path[k] * scale;
  for (int j = 0; j < a->freedom; ++j) {
    const double *c = self + j * a->n;
    double along = 0.0;
    for (int k = 0; k < a->n; ++k)
      along += c[k] * mean[k];
    for (int k = 0; k < a->n; ++k)
      rates[k] += along * c[k];
  }
}

double km_joint_length(const double *x, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    sum += x[i] * x[i];
  return sqrt(sum);
}

/* δ = (c₁/z + tan φ·c₂/z)Δσ. */
static void predict(const km_arm *a, const km_node *here, const km_step_choice *way, double ds, double *step) {
  double inverse = 1.0 / here->z;
  for (int k = 0; k < a->n; ++k) {
    double rate = here->path[k];
    for (int j = 0; way->tilt && j < a->freedom; ++j)
      rate += way->tilt[j] * here->self[j * a->n + k];
    step[k] = rate * inverse * ds;
  }
}

int km_node_known_bends(const km_arm *a, const km_node *here, const km_step_choice *way, double ds) {
  static const double same = 1e-6; /* of Δσ */
  bool on = here->bends > 0 && fabs(ds - here->along) <= same * ds;
  for (int j = 0; j < a->freedom && on; ++j)
    on = here->tilt[j] == (way->tilt ? way->tilt[j] : 0.0);
  return on ? here->bends : 0;
}

/* The corrector to expect of a step: the last ones drawn on along a line, 0 where there are none. */
static void expect(const km_arm *a, const km_node *here, const km_step_choice *way, double ds, double most,
                   double *moved) {
  const double *last = here->bend, *before = last + a->n;
  int known = km_node_known_bends(a, here, way, ds);
  for (int k = 0; k < a->n; ++k) {
    bool moves = known > 0 && !(way->held && way->held[k]);
    moved[k] = !moves ? 0.0 : known > 1 ? 2.0 * last[k] - before[k] : last[k];
  }
  if (known > 0 && !(km_joint_length(moved, a->n) <= most))
    memset(moved, 0, (size_t)a->n * sizeof *moved);
}

double km_node_predict(const km_arm *a, const km_node *here, const km_step_choice *way, double ds, double *step,
                       double *moved) {
  predict(a, here, way, ds, step);
  double most = 0.5 * km_joint_length(step, a->n) + 1e-12; /* half the predictor, but for rounding */
  expect(a, here, way, ds, most, moved);
  return most;
}

void km_node_remember(const km_arm *a, const km_node *from, const km_step_choice *way, double ds, const double *moved,
                      km_node *to) {
  const size_t n = (size_t)a->n;
  bool on = km_node_known_bends(a, from, way, ds) > 0;
  memcpy(to->bend + n, from->bend, n * sizeof *moved);
  memcpy(to->bend, moved, n * sizeof *moved);
  for (int j = 0; j < a->freedom; ++j)
    to->tilt[j] = way->tilt ? way->tilt[j] : 0.0;
  to->along = ds;
  to->bends = !on ? 1 : KM_NODE_BENDS;
}
