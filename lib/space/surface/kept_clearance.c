/* A least clearance that the configurations of a map keep (space/surface/kept_clearance.h). */
#include "space/surface/kept_clearance.h"

#include "kinematics/body_poses.h"

#include <math.h>

bool km_kept_clearance_create(km_kept_clearance *kept, const km_mechanism *m, km_arena *arena) {
  kept->pairs = KM_ARENA_NEW(arena, km_pair_clearance, (size_t)km_kept_clearance_count(kept) + 1);
  kept->gradient = KM_ARENA_NEW(arena, double, (size_t)m->coordinate_count + 1);
  return !arena->failed;
}

void km_kept_clearance_update(km_kept_clearance *kept, const km_mechanism *m, km_state *s) {
  if (!kept->clearance)
    return;
  km_poses_compute(m, s);
  km_clearance_compute(kept->clearance, s, kept->pairs, NULL, NULL);
}

int km_kept_clearance_count(const km_kept_clearance *kept) {
  return kept->clearance ? km_clearance_pair_count(kept->clearance) : 0;
}

double km_kept_clearance_excess(const km_kept_clearance *kept, int pair) {
  return kept->pairs[pair].distance - kept->least;
}

double km_kept_clearance_least(const km_kept_clearance *kept, int except) {
  double least = HUGE_VAL;
  for (int i = 0; i < km_kept_clearance_count(kept); ++i)
    if (i != except)
      least = fmin(least, km_kept_clearance_excess(kept, i));
  return least;
}
