/* Poses between the rows of a sweep by a driver, for observers that ask for them. */
#include "analysis/sweeper.h"

/* Drives on to s and shows the observer that pose; false where the driver stops before it, or the observer fails. */
static bool show(km_sweeper *r, km_drive *d, double s, km_status *status, km_error *error) {
  if (km_drive_to(d, s).stop)
    return false;
  *status = r->observer->passed(r->observer->self, r, s, error);
  return !*status;
}

/* From the first row to s: the poses close to the row, and s. */
static km_status begin(km_sweeper *r, km_drive *d, double from, double s, km_error *error) {
  km_status status = KM_OK;
  bool goes_on = !km_sweeper_meets(r);
  for (int k = KM_END_PLACES; k >= 0 && goes_on; --k)
    goes_on = show(r, d, k ? km_sweeper_near_end(s, from, k) : s, &status, error);
  return status;
}

/* From s to the last row: the poses close to the row. */
static km_status end(km_sweeper *r, km_drive *d, double s, double last, km_error *error) {
  km_status status = KM_OK;
  bool goes_on = true;
  for (int k = 1; k <= KM_END_PLACES && goes_on; ++k)
    goes_on = show(r, d, km_sweeper_near_end(s, last, k), &status, error);
  return status;
}

/* Where a way to s ends, and whether at a place whose neighbours are worth a look; comes back. */
static km_reach look_ahead(km_sweeper *r, km_drive *d, double s, bool *meets) {
  km_drive_mark(d);
  km_reach reach = km_drive_to(d, s);
  *meets = km_sweeper_meets(r);
  km_drive_return(d);
  return reach;
}

km_status km_sweeper_pass(km_sweeper *r, km_drive *d, double from, double to, bool begins, bool ends, km_error *error) {
  int pieces = (KM_LEAST_SAMPLES + r->plan->steps - 1) / r->plan->steps;
  double last = from;
  km_status status = KM_OK;
  for (int k = 1; k <= pieces && !status; ++k) {
    bool meets;
    double s = k == pieces ? to : from + (to - from) * k / pieces;
    km_reach ahead = look_ahead(r, d, s, &meets);
    if (ahead.stop == KM_STOP_GAVE_OUT) /* so will the way to the row */
      return KM_OK;
    double next = ahead.position;
    bool over = ahead.stop || (ends && k == pieces); /* the row will be there */
    double middle = over ? 0.5 * (last + next) : next;
    if (begins && k == 1) {
      status = begin(r, d, from, middle, error);
      last = middle;
    } else if (k < pieces && !over) {
      status = km_drive_to(d, s).stop ? KM_OK : r->observer->passed(r->observer->self, r, s, error);
      last = s;
    }
    if (over)
      return status || meets ? status : end(r, d, last, next, error);
  }
  return status;
}
