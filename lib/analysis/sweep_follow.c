/* Sweeps by arc length. */
#include "analysis/sweeper.h"
#include "kmech/follow.h"

static bool rates(void *self, double *out) {
  km_follow_tangent(self, out);
  return true;
}

static bool probe(void *self, double s, double *out) { return km_follow_probe(self, s - km_follow_length(self), out); }

static void settle(void *self, double s) {
  (void)self; /* a probe doesn't leave the row */
  (void)s;
}

static km_status add_branches(km_mobility_sweep *out, const km_follow *follow, km_error *error) {
  for (int i = 0; i < km_follow_branch_count(follow); ++i) {
    void *branches = out->branches;
    if (!km_reserve(&branches, &out->branch_capacity, out->branch_count + 1, sizeof *out->branches))
      return km_fail(error, KM_MEMORY, "out of memory for the branch points");
    out->branches = branches;
    out->branches[out->branch_count++] = km_follow_branch(follow, i);
  }
  return KM_OK;
}

static km_stop reason(const km_follow *follow, km_status moved) {
  return !moved ? KM_STOP_NONE : km_follow_limit(follow) >= 0 ? KM_STOP_LIMIT : KM_STOP_TOGGLE;
}

static km_status rows(km_sweeper *r, km_follow *follow, km_error *error) {
  const km_sweep_plan *plan = r->plan;
  km_status status = km_sweeper_row(r, 0, 0.0, error);
  for (int i = 1; i <= plan->steps && !status; ++i) {
    if (!km_sweeper_goes_on(r, i))
      return km_fail(error, KM_CANCELLED, "stopped at %g", km_follow_length(follow));
    km_status moved = km_follow_advance(follow, plan->arclength * i - km_follow_length(follow));
    status = add_branches(r->out, follow, error);
    r->out->end = (km_reach){reason(follow, moved), km_follow_length(follow), r->substructure, km_follow_limit(follow)};
    if (km_follow_closed(follow)) {
      r->out->cycle = km_follow_length(follow);
      return status; /* the row that repeats the start is left out */
    }
    if (!status)
      status = km_sweeper_row(r, i, km_follow_length(follow), error);
    if (moved)
      return status ? status : KM_PARTIAL;
  }
  return !status && plan->cycle ? KM_PARTIAL : status;
}

km_status km_sweep_by_length(km_sweeper *r, km_error *error) {
  km_follow *follow;
  km_sweeper_prepare(r);
  km_status status = km_follow_create(r->m, r->s, r->plan->direction, r->plan->sign, r->plan->ignore_limits, &follow, error);
  if (status)
    return status;
  r->mover = (km_mover){follow, rates, probe, settle};
  r->substructure = r->out->substructure = km_follow_substructure(follow);
  km_sweeper_prepare(r);
  status = rows(r, follow, error);
  km_follow_free(follow);
  return status;
}
