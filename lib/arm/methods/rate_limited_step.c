/* Easing: moves tan φ by least distances to a value that satisfies the joint rates (docs/theory.md 12.4).
 *
 *   rate_k = (c1_k + sum_j tan_phi_j c2_jk) speed/z;   |rate_k| <= limit_k   is a slab in the space of tan_phi
 *   cyclic projection onto the slabs (Kaczmarz's method) until all hold; one freedom: the closest such tan_phi */
#include "arm/tracking/tracker.h"

#include <string.h>

bool km_tracker_rated(const km_arm *a) {
  for (int k = 0; k < a->n; ++k)
    if (a->rate[k] < (double)INFINITY)
      return true;
  return false;
}

/* Cyclic projection: moves tan_phi, joint by joint, by the least distance at which the joint's rate is (1 − margin)
 * of its limit, until all rates are below (1 − margin/2). False: no such tan_phi, or not found. */
static bool limit_rates(const km_arm *a, const km_path_node *node, double speed, double margin, double *tan_phi) {
  enum { MAX_SWEEPS = 100 };
  const double scale = speed / node->z;
  for (int sweep = 0; sweep < MAX_SWEEPS; ++sweep) {
    bool within = true;
    for (int k = 0; k < a->n; ++k) {
      double rate = node->path[k], size = 0.0, most = (1.0 - margin) * a->rate[k] / scale;
      for (int j = 0; j < a->freedom; ++j) {
        double side = node->self[j * a->n + k];
        rate += tan_phi[j] * side;
        size += side * side;
      }
      if (!(fabs(rate) > (1.0 - 0.5 * margin) * a->rate[k] / scale))
        continue;
      if (size < 1e-12)
        return false;
      within = false;
      double back = (copysign(most, rate) - rate) / size;
      for (int j = 0; j < a->freedom; ++j)
        tan_phi[j] += back * node->self[j * a->n + k];
    }
    if (within)
      return true;
  }
  return false;
}

/* Repeats a step that exceeded a rate with the closest tan φ that satisfies the rates, with growing margins. */
km_step_end km_tracker_ease(const km_tracker *w, km_tracker_space *s, int sample, const km_path_node *from,
                            const km_step_choice *choice, km_step_end end, km_path_node *to) {
  static const double margins[] = {0.001, 0.01, 0.03, 0.1}; /* relative margins, tried in turn, because rates grow
                                                             * along the step */
  const size_t size = (size_t)w->arm->freedom * sizeof *choice->tan_phi;
  double tan_phi[KM_ARM_MAX_JOINTS];
  if (from->z < KM_PATH_ENTRY_LEAST || w->arm->freedom == 0)
    return end;
  for (size_t i = 0; i < sizeof margins / sizeof *margins && end.stop == KM_TRACK_RATE; ++i) {
    memcpy(tan_phi, choice->tan_phi, size);
    if (!limit_rates(w->arm, from, w->path->points[sample].speed, margins[i], tan_phi))
      return end;
    km_step_choice nearest = *choice;
    nearest.tan_phi = tan_phi;
    km_step_end eased = km_tracker_step(w, s, sample, 1.0, from, &nearest, to);
    if (eased.stop == KM_TRACK_COMPLETE)
      return eased;
  }
  return end;
}
