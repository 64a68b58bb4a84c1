/* Steps that keep the rates, where the tilt that was asked for doesn't. */
#include "arm/tracking/tracker.h"

#include <string.h>

bool km_tracker_rated(const km_arm *a) {
  for (int k = 0; k < a->n; ++k)
    if (a->rate[k] < (double)INFINITY)
      return true;
  return false;
}

/* Moves a tilt by least distances, joint after joint, to where each rate at the node is `margin` below what it may be,
 * until all are half of that: of one freedom that is the nearest such tilt. False: there is none, or it isn't found. */
static bool turn(const km_arm *a, const km_node *node, double speed, double margin, double *tilt) {
  enum { MOST_SWEEPS = 100 };
  const double scale = speed / node->z;
  for (int sweep = 0; sweep < MOST_SWEEPS; ++sweep) {
    bool within = true;
    for (int k = 0; k < a->n; ++k) {
      double rate = node->path[k], size = 0.0, most = (1.0 - margin) * a->rate[k] / scale;
      for (int j = 0; j < a->freedom; ++j) {
        double side = node->self[j * a->n + k];
        rate += tilt[j] * side;
        size += side * side;
      }
      if (!(fabs(rate) > (1.0 - 0.5 * margin) * a->rate[k] / scale))
        continue;
      if (size < 1e-12)
        return false;
      within = false;
      double back = (copysign(most, rate) - rate) / size;
      for (int j = 0; j < a->freedom; ++j)
        tilt[j] += back * node->self[j * a->n + k];
    }
    if (within)
      return true;
  }
  return false;
}

km_step_end km_tracker_ease(const km_tracker *w, km_tracker_space *s, int sample, const km_node *from,
                            const km_step_choice *way, km_step_end end, km_node *to) {
  static const double margins[] = {0.001, 0.01, 0.03, 0.1}; /* rates grow along the step */
  const size_t size = (size_t)w->arm->freedom * sizeof *way->tilt;
  double tilt[KM_ARM_MOST];
  if (from->z < KM_PATH_ENTRY_LEAST || w->arm->freedom == 0)
    return end;
  for (size_t i = 0; i < sizeof margins / sizeof *margins && end.stop == KM_TRACK_RATE; ++i) {
    memcpy(tilt, way->tilt, size);
    if (!turn(w->arm, from, w->path->points[sample].speed, margins[i], tilt))
      return end;
    km_step_choice nearest = *way;
    nearest.tilt = tilt;
    km_step_end eased = km_tracker_step(w, s, sample, 1.0, from, &nearest, to);
    if (eased.stop == KM_TRACK_COMPLETE)
      return eased;
  }
  return end;
}
