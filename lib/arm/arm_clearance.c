/* Least clearance of an arm's bodies from each other and from obstacles (docs/theory.md 12.5, 14.10).
 *
 *   d(q) = min over pairs of the clearance at the configuration of the mechanism with the arm's coordinates q, over
 *          L */
#include "arm/arm.h"
#include "base/arguments.h"

#include <string.h>

km_status km_arm_set_clearance(km_arm *a, const km_state *s, const km_clearance *clearance, km_error *error) {
  km_status status = km_check_given(a && clearance, "arm or clearance", error);
  if (!status)
    status = km_check_state(a->mechanism, s, error);
  if (status)
    return status;
  const size_t count = (size_t)a->mechanism->coordinate_count;
  double *rest = KM_ARENA_NEW(&a->arena, double, count + 1);
  if (!rest)
    return km_fail(error, KM_MEMORY, "out of memory for the clearance of an arm");
  memcpy(rest, s->q, count * sizeof *rest);
  a->rest = rest;
  a->clearance = clearance;
  return KM_OK;
}

bool km_arm_clearance_create(const km_arm *a, km_arm_space *space) {
  if (!a->clearance)
    return true;
  space->near = KM_ARENA_NEW(&space->arena, km_pair_clearance, (size_t)km_clearance_pair_count(a->clearance));
  return space->near && km_state_create(a->mechanism, &space->state, NULL) == KM_OK;
}

double km_arm_clearance(const km_arm *a, km_arm_space *space, const double *q) {
  int nearest;
  if (!space->state)
    return HUGE_VAL;
  memcpy(space->state->q, a->rest, (size_t)a->mechanism->coordinate_count * sizeof *q);
  for (int k = 0; k < a->n; ++k)
    space->state->q[a->coordinate[k]] = a->unit[k] * q[k];
  km_poses_compute(a->mechanism, space->state);
  if (km_clearance_compute(a->clearance, space->state, space->near, &nearest, NULL))
    return nan("");
  return space->near[nearest].distance / a->length;
}
