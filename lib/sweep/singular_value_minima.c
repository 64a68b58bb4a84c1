/* Approach to a gain of mobility: minima of the smallest kept singular value of J D⁻¹ along a sweep (theory 10.4). */
#include "sweep/singular_value_minima.h"

static const km_substructure *moving_substructure(const km_sweeper *r) {
  return &r->m->substructures[r->substructure];
}

/* Returns singular value `index` (from 1) at the state's configuration. */
static double value_at(km_singular_value_minima *w, const km_sweeper *r, int index) {
  int count;
  const double *values = km_singular_values(w->singular, r->m, r->s, moving_substructure(r), &count);
  return index > 0 && index <= count ? values[index - 1] : nan("");
}

static void compute_value(void *self, km_sweeper *r, double *value, double *denominator) {
  km_singular_value_minima *w = self;
  (void)denominator; /* minima of the value, not zeros of a quotient */
  km_sweeper_update_motions(r);
  *value = value_at(w, r, w->regular_rank);
}

bool km_singular_value_minima_create(km_singular_value_minima *w, const km_mechanism *m, const km_sweep_plan *plan) {
  *w = (km_singular_value_minima){.singular = km_singular_value_workspace_create(m)};
  w->search = (km_event_search){
      .self = w, .values = compute_value, .extremes = true, .accepts_best_sample = true, .events = &w->events};
  return km_event_search_reserve(&w->search, 1, plan) && w->singular;
}

void km_singular_value_minima_free(km_singular_value_minima *w) {
  km_singular_value_workspace_free(w->singular);
  km_event_search_free(&w->search);
  km_free(w->events.items);
}

double km_singular_value_kept(km_singular_value_minima *w, const km_sweeper *r) {
  if (r->substructure < 0 || !km_singular_values_fit(moving_substructure(r)))
    return nan("");
  return value_at(w, r, km_factor_rank(r->s->factor[r->substructure]));
}

static bool add_minimum(km_mobility_sweep *out, km_extreme minimum) {
  void *minima = out->minima;
  if (!km_reserve(&minima, &out->minimum_capacity, out->minimum_count + 1, sizeof minimum))
    return false;
  out->minima = minima;
  out->minima[out->minimum_count++] = minimum;
  return true;
}

static void keep_smaller(km_extreme *smallest, km_extreme found) {
  if (found.number < smallest->number || isnan(smallest->number))
    *smallest = found;
}

km_status km_singular_value_minima_sample(km_singular_value_minima *w, km_sweeper *r, double s, km_mobility_sweep *out,
                                          km_error *error) {
  if (!w->singular || r->substructure < 0)
    return KM_OK;
  if (!km_singular_values_fit(moving_substructure(r)))
    return km_fail(error, KM_USAGE, "singular values of substructure %d, which has %d coordinates; expected at most %d",
                   r->substructure + 1, moving_substructure(r)->columns, KM_MAX_SINGULAR);
  int rank = km_factor_rank(r->s->factor[r->substructure]);
  if (rank > w->regular_rank) { /* singular values with different indices are not comparable: the search starts anew */
    w->regular_rank = rank;
    km_event_search_restart(&w->search);
  }
  size_t known = w->events.count;
  km_status status = km_event_search_sample(&w->search, r, s, error);
  keep_smaller(&out->smallest, (km_extreme){km_event_numerator(&w->search, 0, 0), s});
  for (size_t i = known; i < w->events.count && !status; ++i) {
    km_extreme minimum = {w->events.items[i].value, w->events.items[i].s};
    if (w->events.items[i].kind != KM_EVENT_MINIMUM)
      continue;
    keep_smaller(&out->smallest, minimum);
    if (!add_minimum(out, minimum))
      status = km_fail(error, KM_MEMORY, "out of memory for the singular values");
  }
  return status;
}
