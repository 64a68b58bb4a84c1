/* Sweeps by one driven coordinate. */
#include "analysis/sweeper.h"

#include <math.h>

/* A drive, and whether it has left the row for a look at poses beside it. */
typedef struct seat {
  km_drive *drive;
  bool away;
} seat;

static km_drive *drive_of(const km_sweeper *r) {
  return ((const seat *)r->mover.self)->drive;
}

/* FROM is out of reach and the motion towards it ended at a bound: does s lie in what is left of the range? */
static bool reachable(const km_sweeper *r, double s) {
  const km_sweep_plan *plan = r->plan;
  double bound = r->out->start.position, away = plan->to >= plan->from ? 1.0 : -1.0;
  return away * (bound - plan->from) > 0.0 && away * (s - bound) > 1e-9 * (1.0 + fabs(bound));
}

/* Drives on to s and shows the observer that pose; false where the driver stops before it, or the observer fails. */
static bool show(km_sweeper *r, double s, km_status *status, km_error *error) {
  if (km_drive_to(drive_of(r), s).stop)
    return false;
  *status = r->observer->passed(r->observer->self, r, s, error);
  return !*status;
}

/* From the first row to s: the poses close to the row, and s. */
static km_status begin(km_sweeper *r, double from, double s, km_error *error) {
  km_status status = KM_OK;
  bool goes_on = !km_sweeper_meets(r);
  for (int k = KM_END_PLACES; k >= 0 && goes_on; --k)
    goes_on = show(r, k ? km_sweeper_near_end(s, from, k) : s, &status, error);
  return status;
}

/* From s to the last row: the poses close to the row. */
static km_status end(km_sweeper *r, double s, double last, km_error *error) {
  km_status status = KM_OK;
  bool goes_on = true;
  for (int k = 1; k <= KM_END_PLACES && goes_on; ++k)
    goes_on = show(r, km_sweeper_near_end(s, last, k), &status, error);
  return status;
}

/* Where a way to s ends, and whether at a place whose neighbours are worth a look; comes back. */
static double look_ahead(km_sweeper *r, double s, bool *stops, bool *meets) {
  km_drive_mark(drive_of(r));
  km_reach reach = km_drive_to(drive_of(r), s);
  *stops = reach.stop != KM_STOP_NONE;
  *meets = km_sweeper_meets(r);
  km_drive_return(drive_of(r));
  return reach.position;
}

/* Shows the observer the poses on the way from a row to the next one, if it asks for them: all the nearer to one
 * another where the motion begins or ends. */
static km_status pass(km_sweeper *r, double from, double to, bool begins, bool ends, km_error *error) {
  int pieces = (KM_LEAST_SAMPLES + r->plan->steps - 1) / r->plan->steps;
  double last = from;
  km_status status = KM_OK;
  for (int k = 1; k <= pieces && r->observer->passed && !status; ++k) {
    bool stops, meets;
    double s = k == pieces ? to : from + (to - from) * k / pieces, next = look_ahead(r, s, &stops, &meets);
    bool over = stops || (ends && k == pieces); /* the row will be there */
    double middle = over ? 0.5 * (last + next) : next;
    if (begins && k == 1) {
      status = begin(r, from, middle, error);
      last = middle;
    } else if (k < pieces && !over) {
      status = km_drive_to(drive_of(r), s).stop ? KM_OK : r->observer->passed(r->observer->self, r, s, error);
      last = s;
    }
    if (over)
      return status || meets ? status : end(r, last, next, error);
  }
  return status;
}

static km_status rows(km_sweeper *r, km_error *error) {
  km_drive *drive = drive_of(r);
  const km_sweep_plan *plan = r->plan;
  km_reach *start = &r->out->start, *end = &r->out->end;
  *start = *end = km_drive_to(drive, plan->from);
  km_status status = km_sweeper_row(r, 0, start->position, error);
  int row = 1;
  double last = start->position;
  for (int i = 1; i <= plan->steps && !status; ++i) {
    double s = i == plan->steps ? plan->to : plan->from + (plan->to - plan->from) * i / plan->steps;
    if (start->stop && !reachable(r, s))
      continue;
    if (!km_sweeper_goes_on(r, i))
      return km_fail(error, KM_CANCELLED, "stopped at %g", s);
    int crossings = km_drive_crossings(drive);
    status = pass(r, last, s, row == 1, i == plan->steps, error);
    if (status)
      return status;
    *end = km_drive_to(drive, s);
    bool again = end->stop && fabs(end->position - last) <= 1e-9 * (1.0 + fabs(last));
    if (!again) /* the end may be where the last row stands already */
      status = km_sweeper_row(r, row++, end->position, error);
    if (!status && km_drive_crossings(drive) > crossings && r->substructure >= 0)
      status = km_sweeper_find_branch(r, error);
    last = end->position;
    if (end->stop)
      break;
  }
  for (int i = 0; i < 2 && !status; ++i) { /* where the driver itself gives out */
    const km_reach *reach = i ? end : start;
    bool again = i && end->position == start->position;
    if (reach->stop == KM_STOP_TOGGLE && !again && r->observer->ended)
      status = r->observer->ended(r->observer->self, r, reach->position, error);
  }
  if (status)
    return status;
  if (start->stop == KM_STOP_GAVE_OUT || end->stop == KM_STOP_GAVE_OUT)
    return km_fail(error, KM_DIVERGED,
                   "the sweep gave out at %.9g: too many steps to the next row; expected a range that "
                   "so many rows resolve",
                   end->position);
  return start->stop || end->stop ? KM_PARTIAL : KM_OK;
}

static bool rates(void *self, double *out) {
  return km_drive_tangent(((const seat *)self)->drive, out);
}

static bool probe(void *self, double s, double *out) {
  seat *at = self;
  if (at->away)
    km_drive_return(at->drive);
  else
    km_drive_mark(at->drive);
  at->away = true;
  return !km_drive_to(at->drive, s).stop && km_drive_tangent(at->drive, out);
}

static void settle(void *self) {
  seat *at = self;
  if (at->away)
    km_drive_return(at->drive);
  at->away = false;
}

km_status km_sweep_by_driver(km_sweeper *r, km_error *error) {
  seat at = {NULL, false};
  r->substructure = r->out->substructure = r->m->substructure_of[r->plan->coordinate];
  km_status status = km_sweeper_leave_branch(r, r->plan->coordinate, error);
  if (!status)
    status = km_sweep_enter_limits(r->m, r->s, r->plan, error);
  if (status)
    return status;
  status = km_drive_create(r->m, r->s, r->plan->coordinate, r->plan->ignore_limits, &at.drive, error);
  if (status)
    return status;
  r->mover = (km_mover){&at, rates, probe, settle};
  status = km_sweeper_prepare(r, error);
  if (!status)
    status = rows(r, error);
  km_drive_free(at.drive);
  return status;
}
