/* Start of a driven sweep outside the limits: moves the driver to the first configuration within all limits, by steps
 * and bisection. */
#include "sweep/sweep.h"

#include "base/arguments.h"

#include <math.h>

enum { MIN_STEPS = 360 }; /* least number of steps of the search */

typedef struct limit_search {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
} limit_search;

/* Returns a coordinate outside its limits among those that the driver moves; -1: none. */
static int find_outside(const limit_search *r) {
  int substructure = r->m->substructure_of[r->plan->coordinate];
  if (substructure >= 0)
    return km_state_find_outside_limit(r->s, &r->m->substructures[substructure]);
  return km_state_is_outside(r->s, r->plan->coordinate) ? r->plan->coordinate : -1;
}

/* Bisects between an outer and an inner position of the driver; the state ends within the limits. */
static void bisect_limit(const limit_search *r, km_driver_motion *drive, double outer, double inner) {
  while (fabs(inner - outer) > 1e-12 * (1.0 + fabs(inner))) {
    double middle = 0.5 * (outer + inner);
    km_driver_motion_move_to(drive, middle);
    if (find_outside(r) < 0)
      inner = middle;
    else
      outer = middle;
  }
  km_driver_motion_move_to(drive, inner);
}

/* Moves from `*at` towards `to` until all limits hold; false if they hold nowhere. */
static bool move_within_limits(const limit_search *r, km_driver_motion *drive, double *at, double to) {
  int steps = r->plan->steps > MIN_STEPS ? r->plan->steps : MIN_STEPS;
  double from = *at;
  for (int k = 1; k <= steps; ++k) {
    double last = *at;
    km_motion_end reach = km_driver_motion_move_to(drive, k == steps ? to : from + (to - from) * k / steps);
    *at = reach.position;
    if (find_outside(r) < 0) {
      bisect_limit(r, drive, last, *at);
      return true;
    }
    if (reach.stop)
      return false;
  }
  return false;
}

km_status km_sweep_enter_limits(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, km_error *error) {
  km_status fits = km_check_sweep(m, s, plan, error);
  if (!fits) /* a plan by arc length has no driver */
    fits = km_check_index(plan->coordinate, m->coordinate_count, "coordinate", error);
  if (fits)
    return fits;
  const limit_search r = {m, s, plan};
  km_driver_motion *drive;
  if (plan->ignore_limits || find_outside(&r) < 0)
    return KM_OK;
  km_status status = km_driver_motion_create(m, s, plan->coordinate, true, &drive, error);
  if (status)
    return status;
  double at = km_state_coordinate(s, plan->coordinate);
  if (!move_within_limits(&r, drive, &at, plan->from) && !move_within_limits(&r, drive, &at, plan->to))
    status = km_fail(error, KM_NO_RESULT, "no pose from %.9g to %.9g lies within the limits: joint %s is outside",
                     plan->from, plan->to, m->model->coordinates[find_outside(&r)].label);
  km_driver_motion_free(drive);
  return status;
}
