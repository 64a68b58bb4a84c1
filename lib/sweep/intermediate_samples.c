/* Poses between the rows of a sweep by a driver, for observers that ask for them. */
#include "sweep/sweep.h"

/* Drives on to s and shows the observer that pose; false where the driver stops before it, or the observer fails. */
static bool show(km_sweeper *r, km_driver_motion *d, double s, km_status *status, km_error *error) {
  if (km_driver_motion_move_to(d, s).stop)
    return false;
  *status = r->observer->passed(r->observer->self, r, s, error);
  return !*status;
}

/* From the first row to s: the poses close to the row, and s. To a branch point from which several freedoms lead the way back
 * isn't the motion that began there. */
static km_status begin(km_sweeper *r, km_driver_motion *d, double from, double s, km_error *error) {
  km_status status = KM_OK;
  bool goes_on = !km_sweeper_meets(r);
  for (int k = r->branch_point ? 0 : KM_END_PLACES; k >= 0 && goes_on; --k)
    goes_on = show(r, d, k ? km_sweeper_near_end(s, from, k) : s, &status, error);
  return status;
}

/* From s to the last row: the poses close to the row. */
static km_status end(km_sweeper *r, km_driver_motion *d, double s, double last, km_error *error) {
  km_status status = KM_OK;
  bool goes_on = true;
  for (int k = 1; k <= KM_END_PLACES && goes_on; ++k)
    goes_on = show(r, d, km_sweeper_near_end(s, last, k), &status, error);
  return status;
}

/* Drives on to s, and stays there unless something ends the motion before it, or `ends` says that it ends there: then it
 * comes back. Where the way ended, and whether at a place whose neighbours are worth a look. */
static km_motion_end go_on(km_sweeper *r, km_driver_motion *d, double s, bool ends, bool *meets) {
  km_driver_motion_save(d);
  km_motion_end reach = km_driver_motion_move_to(d, s);
  *meets = km_sweeper_meets(r);
  if (reach.stop || ends)
    km_driver_motion_restore(d);
  return reach;
}

int km_sweeper_parts(const km_sweeper *r) {
  return (KM_LEAST_SAMPLES + r->plan->steps - 1) / r->plan->steps;
}

double km_sweeper_part(double from, double to, int k, int parts) {
  return k == parts ? to : from + (to - from) * k / parts;
}

km_status km_sweeper_pass(km_sweeper *r, km_driver_motion *d, const km_sweep_way *way, int first, km_error *error) {
  int parts = km_sweeper_parts(r);
  double last = km_sweeper_part(way->from, way->to, first - 1, parts);
  km_status status = KM_OK;
  for (int k = first; k <= parts && !status; ++k) {
    bool meets, begins = way->begins && k == 1, ends = way->ends && k == parts;
    double s = km_sweeper_part(way->from, way->to, k, parts);
    km_motion_end ahead = go_on(r, d, s, begins || ends, &meets);
    if (ahead.stop == KM_STOP_MAX_STEPS) /* so will the way to the row */
      return KM_OK;
    bool over = ahead.stop || ends; /* the row will be there */
    double middle = over ? 0.5 * (last + ahead.position) : ahead.position;
    if (begins) {
      status = begin(r, d, way->from, middle, error);
      last = middle;
    } else if (k < parts && !over) {
      status = r->observer->passed(r->observer->self, r, s, error);
      last = s;
    }
    if (over)
      return status || meets ? status : end(r, d, last, ahead.position, error);
  }
  return status;
}
