/* Where a sweep comes nearest to gaining a mobility: minima of the smallest singular value. */
#include "sweep/singular_value_minima.h"

static const km_substructure *moving(const km_sweeper *r) {
  return &r->m->substructures[r->substructure];
}

/* Value `index` (from 1) at the state's pose. */
static double value_at(km_singular_value_watch *w, const km_sweeper *r, int index) {
  int count;
  const double *values = km_singular_values(w->singular, r->m, r->s, moving(r), &count);
  return index > 0 && index <= count ? values[index - 1] : nan("");
}

static void generic_value(void *self, km_sweeper *r, double *value, double *one) {
  km_singular_value_watch *w = self;
  (void)one;
  *value = value_at(w, r, w->generic);
}

bool km_singular_value_watch_make(km_singular_value_watch *w, const km_mechanism *m) {
  *w = (km_singular_value_watch){.singular = km_singular_value_workspace_create(m)};
  w->scan = (km_event_search){
      .self = w, .values = generic_value, .extremes = true, .best_counts = true, .events = &w->events};
  return km_event_search_reserve(&w->scan, 1) && w->singular;
}

void km_singular_value_watch_free(km_singular_value_watch *w) {
  km_singular_value_workspace_free(w->singular);
  km_event_search_free(&w->scan);
  km_free(w->events.items);
}

double km_singular_value_kept(km_singular_value_watch *w, const km_sweeper *r) {
  if (r->substructure < 0 || !km_singular_values_fit(moving(r)))
    return nan("");
  return value_at(w, r, r->s->partition[r->substructure].rank);
}

static bool add_minimum(km_mobility_sweep *out, km_extreme minimum) {
  void *minima = out->minima;
  if (!km_reserve(&minima, &out->minimum_capacity, out->minimum_count + 1, sizeof minimum))
    return false;
  out->minima = minima;
  out->minima[out->minimum_count++] = minimum;
  return true;
}

static void take_smaller(km_extreme *smallest, km_extreme found) {
  if (found.number < smallest->number || isnan(smallest->number))
    *smallest = found;
}

km_status km_singular_value_observe(km_singular_value_watch *w, km_sweeper *r, double s, km_mobility_sweep *out,
                                    km_error *error) {
  if (!w->singular || r->substructure < 0)
    return KM_OK;
  if (!km_singular_values_fit(moving(r)))
    return km_fail(error, KM_USAGE, "singular values of substructure %d, which has %d coordinates; expected at most %d",
                   r->substructure + 1, moving(r)->columns, KM_MAX_SINGULAR);
  int rank = r->s->partition[r->substructure].rank;
  if (rank > w->generic) { /* values of different places in the order can't be compared */
    w->generic = rank;
    w->scan.have = 0;
  }
  size_t known = w->events.count;
  km_status status = km_event_search_sample(&w->scan, r, s, error);
  take_smaller(&out->smallest, (km_extreme){w->scan.n[0][0], s});
  for (size_t i = known; i < w->events.count && !status; ++i) {
    km_extreme minimum = {w->events.items[i].value, w->events.items[i].s};
    if (w->events.items[i].kind != KM_EVENT_MINIMUM)
      continue;
    take_smaller(&out->smallest, minimum);
    if (!add_minimum(out, minimum))
      status = km_fail(error, KM_MEMORY, "out of memory for the singular values");
  }
  return status;
}
