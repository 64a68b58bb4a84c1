/* Where a driven sweep may begin whose starting pose is outside the limits. */
#include "sweep/sweep.h"

#include "base/arguments.h"

#include <math.h>

enum { LEAST_PIECES = 360 }; /* of the way that is searched */

typedef struct place {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
} place;

/* The coordinate that is outside its limits, of those that the driver moves; -1: none. */
static int outside(const place *r) {
  int substructure = r->m->substructure_of[r->plan->coordinate];
  if (substructure >= 0)
    return km_state_find_outside_limit(r->s, &r->m->substructures[substructure]);
  return km_state_is_outside(r->s, r->plan->coordinate) ? r->plan->coordinate : -1;
}

/* From an outer to an inner position of the driver: the innermost outer one, from inside. */
static void locate(const place *r, km_driver_motion *drive, double outer, double inner) {
  while (fabs(inner - outer) > 1e-12 * (1.0 + fabs(inner))) {
    double middle = 0.5 * (outer + inner);
    km_driver_motion_move_to(drive, middle);
    if (outside(r) < 0)
      inner = middle;
    else
      outer = middle;
  }
  km_driver_motion_move_to(drive, inner);
}

/* Moves from `*at` towards `to` until all limits hold; false if they don't on the way. */
static bool enter(const place *r, km_driver_motion *drive, double *at, double to) {
  int pieces = r->plan->steps > LEAST_PIECES ? r->plan->steps : LEAST_PIECES;
  double from = *at;
  for (int k = 1; k <= pieces; ++k) {
    double last = *at;
    km_motion_end reach = km_driver_motion_move_to(drive, k == pieces ? to : from + (to - from) * k / pieces);
    *at = reach.position;
    if (outside(r) < 0) {
      locate(r, drive, last, *at);
      return true;
    }
    if (reach.stop)
      return false;
  }
  return false;
}

km_status km_sweep_enter_limits(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, km_error *error) {
  km_status fits = km_check_sweep(m, s, plan, error);
  if (!fits) /* also of a plan by arc length, which names no driver */
    fits = km_check_index(plan->coordinate, m->coordinate_count, "coordinate", error);
  if (fits)
    return fits;
  const place r = {m, s, plan};
  km_driver_motion *drive;
  if (plan->ignore_limits || outside(&r) < 0)
    return KM_OK;
  km_status status = km_driver_motion_create(m, s, plan->coordinate, true, &drive, error);
  if (status)
    return status;
  double at = km_state_coordinate(s, plan->coordinate);
  if (!enter(&r, drive, &at, plan->from) && !enter(&r, drive, &at, plan->to))
    status = km_fail(error, KM_NO_RESULT, "no pose from %.9g to %.9g lies within the limits: joint %s is outside",
                     plan->from, plan->to, m->model->coordinates[outside(&r)].label);
  km_driver_motion_free(drive);
  return status;
}
