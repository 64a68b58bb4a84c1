/* Nodes of a path: a configuration with its columns. Predictor of a step, prediction of Newton's correction from
 * the previous steps, and joint rates (docs/theory.md 12.4).
 *
 *   step  = (c1/z + tan_phi c2/z) ds                   z: path entry of c1
 *   moved = 2 d_1 - d_2                                d_1, d_2: corrections of the last two steps of equal ds, tan_phi
 *   rates = c1/z speed + sum_j (c2_j . mean) c2_j      mean: joint differences over the step's time */
#include "arm/tracking/tracker.h"

#include <string.h>

/* Number of doubles in a node's arrays. */
static size_t node_size(const km_arm *a) {
  size_t n = (size_t)a->n, freedom = (size_t)a->freedom;
  return n + (n + 1) + freedom * n + KM_NODE_CORRECTIONS * n + freedom;
}

bool km_path_node_create(const km_arm *a, km_arena *arena, km_path_node *node) {
  size_t n = (size_t)a->n, freedom = (size_t)a->freedom;
  *node = (km_path_node){.q = KM_ARENA_NEW(arena, double, node_size(a))};
  if (!node->q)
    return false;
  node->path = node->q + n;
  node->self = node->path + n + 1;
  node->corrections = node->self + freedom * n;
  node->tan_phi = node->corrections + KM_NODE_CORRECTIONS * n;
  return true;
}

void km_path_node_copy(const km_arm *a, km_path_node *to, const km_path_node *from) {
  memcpy(to->q, from->q, node_size(a) * sizeof *to->q);
  to->along = from->along;
  to->correction_count = from->correction_count;
  to->z = from->z;
  to->value = from->value;
  to->weight = from->weight;
}

/* Joint rates: c₁/z · speed along the path, plus the part of `mean` along the self-motions. */
void km_path_node_rates(const km_arm *a, const double *path, const double *self, double speed, const double *mean,
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

/* Predictor step = (c₁/z + tan φ · c₂/z) Δσ. */
static void predict(const km_arm *a, const km_path_node *here, const km_step_choice *choice, double ds, double *step) {
  double inverse = 1.0 / here->z;
  for (int k = 0; k < a->n; ++k) {
    double rate = here->path[k];
    for (int j = 0; choice->tan_phi && j < a->freedom; ++j)
      rate += choice->tan_phi[j] * here->self[j * a->n + k];
    step[k] = rate * inverse * ds;
  }
}

int km_path_node_valid_corrections(const km_arm *a, const km_path_node *here, const km_step_choice *choice, double ds) {
  static const double same = 1e-6; /* relative to Δσ */
  bool on = here->correction_count > 0 && fabs(ds - here->along) <= same * ds;
  for (int j = 0; j < a->freedom && on; ++j)
    on = here->tan_phi[j] == (choice->tan_phi ? choice->tan_phi[j] : 0.0);
  return on ? here->correction_count : 0;
}

/* Extrapolated correction `moved`: linear in the last two corrections, the last one if only one is valid, else 0;
 * also 0 if longer than `most`. */
static void extrapolate_correction(const km_arm *a, const km_path_node *here, const km_step_choice *choice, double ds,
                                   double most, double *moved) {
  const double *last = here->corrections, *before = last + a->n;
  int known = km_path_node_valid_corrections(a, here, choice, ds);
  for (int k = 0; k < a->n; ++k) {
    bool moves = known > 0 && !(choice->fixed && choice->fixed[k]);
    moved[k] = !moves ? 0.0 : known > 1 ? 2.0 * last[k] - before[k] : last[k];
  }
  if (known > 0 && !(km_joint_length(moved, a->n) <= most))
    memset(moved, 0, (size_t)a->n * sizeof *moved);
}

/* Predictor step and extrapolated correction of a step. */
double km_path_node_predict(const km_arm *a, const km_path_node *here, const km_step_choice *choice, double ds,
                            double *step, double *moved) {
  predict(a, here, choice, ds, step);
  double most = 0.5 * km_joint_length(step, a->n) + 1e-12; /* half the predictor, plus rounding */
  extrapolate_correction(a, here, choice, ds, most, moved);
  return most;
}

void km_path_node_store_correction(const km_arm *a, const km_path_node *from, const km_step_choice *choice, double ds,
                                   const double *moved, km_path_node *to) {
  const size_t n = (size_t)a->n;
  bool on = km_path_node_valid_corrections(a, from, choice, ds) > 0;
  memcpy(to->corrections + n, from->corrections, n * sizeof *moved);
  memcpy(to->corrections, moved, n * sizeof *moved);
  for (int j = 0; j < a->freedom; ++j)
    to->tan_phi[j] = choice->tan_phi ? choice->tan_phi[j] : 0.0;
  to->along = ds;
  to->correction_count = !on ? 1 : KM_NODE_CORRECTIONS;
}
