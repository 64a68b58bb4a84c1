/* Samples between the rows of a driven sweep, for observers with sampled_between (theory 10.1, 10.2). */
#include "sweep/sweep.h"

/* Moves to s and takes a sample; false if the motion ends before s or the observer fails. */
static bool take_sample(km_sweeper *r, km_driver_motion *d, double s, km_status *status, km_error *error) {
  if (km_driver_motion_move_to(d, s).stop)
    return false;
  *status = r->observer->sampled_between(r->observer->self, r, s, error);
  return !*status;
}

/* Samples from the first row to s at distances (s − from)/4^k, k descending. No samples if the state is at a branch
 * point; only the one at s if the first row is a branch point with several freedoms, because a motion back towards
 * it takes another path. */
static km_status sample_after_start(km_sweeper *r, km_driver_motion *d, double from, double s, km_error *error) {
  km_status status = KM_OK;
  bool continues = !km_sweeper_is_at_branch_point(r);
  for (int k = r->branch_first_row ? 0 : KM_END_SAMPLES; k >= 0 && continues; --k)
    continues = take_sample(r, d, k ? km_sweeper_end_sample(s, from, k) : s, &status, error);
  return status;
}

/* Samples from s to the last row, densely near the row. */
static km_status sample_before_end(km_sweeper *r, km_driver_motion *d, double s, double last, km_error *error) {
  km_status status = KM_OK;
  bool continues = true;
  for (int k = 1; k <= KM_END_SAMPLES && continues; ++k)
    continues = take_sample(r, d, km_sweeper_end_sample(s, last, k), &status, error);
  return status;
}

/* Moves to s and stays there, unless the motion ends before it or `is_end` is set: then it returns. *at_branch_point:
 * the state reached a branch point, near which no samples are useful. */
static km_motion_end advance_to_sample(km_sweeper *r, km_driver_motion *d, double s, bool is_end,
                                       bool *at_branch_point) {
  km_driver_motion_save(d);
  km_motion_end reach = km_driver_motion_move_to(d, s);
  *at_branch_point = km_sweeper_is_at_branch_point(r);
  if (reach.stop || is_end)
    km_driver_motion_restore(d);
  return reach;
}

int km_sweeper_interval_parts(const km_sweeper *r) {
  return (KM_MIN_SAMPLES + r->plan->steps - 1) / r->plan->steps;
}

double km_sweeper_part_end(double from, double to, int k, int parts) {
  return k == parts ? to : from + (to - from) * k / parts;
}

km_status km_sweeper_sample_to_row(km_sweeper *r, km_driver_motion *d, const km_row_interval *way, int first,
                                   km_error *error) {
  int parts = km_sweeper_interval_parts(r);
  double last = km_sweeper_part_end(way->from, way->to, first - 1, parts);
  km_status status = KM_OK;
  for (int k = first; k <= parts && !status; ++k) {
    bool at_branch_point, is_first = way->is_first && k == 1, is_last = way->is_last && k == parts;
    double s = km_sweeper_part_end(way->from, way->to, k, parts);
    km_motion_end reached = advance_to_sample(r, d, s, is_first || is_last, &at_branch_point);
    if (reached.stop == KM_STOP_MAX_STEPS) /* the move to the row has the same result */
      return KM_OK;
    bool ends_here = reached.stop || is_last; /* the next row is at the end */
    double middle = ends_here ? 0.5 * (last + reached.position) : reached.position;
    if (is_first) {
      status = sample_after_start(r, d, way->from, middle, error);
      last = middle;
    } else if (k < parts && !ends_here) {
      status = r->observer->sampled_between(r->observer->self, r, s, error);
      last = s;
    }
    if (ends_here)
      return status || at_branch_point ? status : sample_before_end(r, d, last, reached.position, error);
  }
  return status;
}
