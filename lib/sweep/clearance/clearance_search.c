/* Clearances along a sweep (theory 10.7).
 *
 *   d_i(s)   clearance of pair i, negative in an overlap: a contact is a zero, by its change of sign or as a dip
 *   min d_i  minima of the least clearance between samples: it has corners, where another pair becomes the nearest */
#include "sweep/clearance/clearance_search.h"

#include "base/number/tolerances.h"
#include "kinematics/body_poses.h"

#include <math.h>

static double compute(km_clearance_search *w, km_sweeper *r, int *nearest) {
  km_poses_compute(r->m, r->s);
  km_clearance_compute(w->clearance, r->s, w->now, nearest, NULL);
  return w->now[*nearest].distance;
}

static void contact_values(void *self, km_sweeper *r, double *n, double *d) {
  km_clearance_search *w = self;
  int nearest;
  double least = compute(w, r, &nearest);
  (void)d;
  if (!w->contacts.is_probing)
    w->sampled = (km_peak){least, nearest};
  for (int i = 0; i < w->count; ++i)
    n[i] = w->now[i].distance;
}

static void least_value(void *self, km_sweeper *r, double *n, double *d) {
  km_clearance_search *w = self;
  (void)d;
  *n = w->sampled.value;
  if (!w->least.is_probing)
    return;
  int nearest;
  *n = compute(w, r, &nearest);
  if (!(w->probed.value <= *n))
    w->probed = (km_peak){*n, nearest};
}

km_status km_clearance_search_create(const km_sweep_plan *plan, km_clearance_course *out, bool table_only,
                                     km_clearance_search *w, km_error *error) {
  const int count = km_clearance_pair_count(plan->clearance);
  *w = (km_clearance_search){.clearance = plan->clearance, .out = out, .count = count};
  *out = (km_clearance_course){.clearance = plan->clearance, .smallest = {nan(""), nan("")}, .smallest_pair = -1};
  if (!w->clearance)
    return KM_OK;
  w->contacts = (km_event_search){.self = w,
                                  .values = contact_values,
                                  .ratios = true,
                                  .dips = true,
                                  .events = table_only ? NULL : &w->contact_events};
  w->least = (km_event_search){.self = w,
                               .values = least_value,
                               .extremes = true,
                               .accepts_best_sample = true,
                               .events = table_only ? NULL : &w->least_events};
  w->now = KM_NEW(km_pair_clearance, (size_t)count);
  w->overlaps = KM_NEW(bool, (size_t)count);
  out->least = KM_NEW(km_extreme, (size_t)count);
  if (!w->now || !w->overlaps || !out->least || !km_event_search_reserve(&w->contacts, count, plan) ||
      !km_event_search_reserve(&w->least, 1, plan))
    return km_fail(error, KM_MEMORY, "out of memory for clearances");
  out->pair_count = count;
  for (int i = 0; i < count; ++i)
    out->least[i] = (km_extreme){nan(""), nan("")};
  return KM_OK;
}

void km_clearance_search_free(km_clearance_search *w) {
  km_event_search_free(&w->contacts);
  km_event_search_free(&w->least);
  km_free(w->contact_events.items);
  km_free(w->least_events.items);
  km_free(w->now);
  km_free(w->overlaps);
}

bool km_clearance_search_columns(const km_clearance_search *w, const km_sweeper *r, km_table *table) {
  const char *unit = r->m->model->units.length->suffix;
  bool added = w->count == 0 || km_table_add_joined_column(table, "clearance", "", "", unit);
  for (int i = 0; i < w->count && added; ++i)
    added = km_table_add_joined_column(table, "clearance.", km_clearance_pair_name(w->clearance, i), "", unit);
  return added;
}

double *km_clearance_search_cells(km_clearance_search *w, km_sweeper *r, double *cell) {
  int nearest;
  if (w->count == 0)
    return cell;
  *cell++ = compute(w, r, &nearest);
  for (int i = 0; i < w->count; ++i)
    *cell++ = w->now[i].distance;
  return cell;
}

/* The first of equal values counts. */
static bool is_less(const km_clearance_search *w, double value, double than) {
  return value < than - w->contacts.zero || isnan(than);
}

static void take(km_clearance_search *w, double value, double s, int pair) {
  km_clearance_course *out = w->out;
  if (is_less(w, value, out->least[pair].number))
    out->least[pair] = (km_extreme){value, s};
  if (!is_less(w, value, out->smallest.number))
    return;
  out->smallest = (km_extreme){value, s};
  out->smallest_pair = pair;
}

/* The first sample, and least values of all. */
static void take_sample(km_clearance_search *w, double s) {
  for (int i = 0; i < w->count; ++i) {
    double d = km_event_numerator(&w->contacts, i, 0);
    w->overlaps[i] = w->has_sample ? w->overlaps[i] : d < 0.0;
    take(w, d, s, i);
  }
  w->has_sample = true;
}

km_status km_clearance_search_sample(km_clearance_search *w, km_sweeper *r, double s, km_error *error) {
  if (w->count == 0 || !w->contacts.events)
    return KM_OK;
  w->contacts.zero = km_relative_zero * r->m->length;
  km_status status = km_event_search_sample(&w->contacts, r, s, error);
  if (status)
    return status;
  take_sample(w, s);
  size_t known = w->least_events.count;
  w->probed = (km_peak){nan(""), -1.0};
  status = km_event_search_sample(&w->least, r, s, error);
  for (size_t i = known; i < w->least_events.count && !status; ++i) {
    const km_event *e = &w->least_events.items[i];
    const int pair = (int)w->probed.s;
    if (e->kind == KM_EVENT_MINIMUM && pair >= 0)
      take(w, e->value, e->s, pair);
  }
  return status;
}

void km_clearance_search_restart(km_clearance_search *w) {
  if (w->count == 0)
    return;
  km_event_search_restart(&w->contacts);
  km_event_search_restart(&w->least);
}

km_status km_clearance_search_finish(km_clearance_search *w, const km_sweep_plan *plan, km_error *error) {
  km_clearance_course *out = w->out;
  if (w->count == 0)
    return KM_OK;
  km_events_sort(&w->contact_events, plan);
  out->contacts = KM_NEW(km_contact_event, w->contact_events.count + 1);
  if (!out->contacts)
    return km_fail(error, KM_MEMORY, "out of memory for contacts");
  for (size_t i = 0; i < w->contact_events.count; ++i) {
    const km_event *e = &w->contact_events.items[i];
    out->contacts[out->contact_count++] = (km_contact_event){e->function, w->overlaps[e->function], e->s};
    w->overlaps[e->function] = !w->overlaps[e->function];
  }
  return KM_OK;
}

void km_clearance_course_free(km_clearance_course *course) {
  if (!course)
    return;
  km_free(course->least);
  km_free(course->contacts);
  *course = (km_clearance_course){0};
}
