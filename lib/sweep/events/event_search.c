/* Events of f = n/d between the samples of a sweep (theory 10.1).
 *
 *   zero : root of n;   pole: root of d;   undefined: both      sign change; n or d drops to 1e-7
 *   extremum of f      : middle one of three samples            to 4 sqrt(eps)
 *   near a pole        : 16 samples at halved distances, for extrema next to it and for pictures
 *   between samples    : event_location.c */
#include "sweep/events/event_search.h"
#include "base/number/tolerances.h"

#include "sweep/events/event_location.h"

#include <math.h>
#include <string.h>

enum { POLE_SAMPLES = 16 }; /* samples towards a pole, the last one at 2⁻¹⁶ of the distance */

bool km_event_search_reserve(km_event_search *search, int count, const km_sweep_plan *plan) {
  size_t n = (size_t)count;
  search->count = count;
  search->sampled_pole = nan("");
  search->window = (km_sample_window){.width = 2 * n, .sense = km_sweep_sense(plan), .last = -1, .row = -1};
  size_t kept = search->ends ? KM_MAX_END_SAMPLES * n : 0;
  search->probe_n = KM_NEW(double, 2 * n + 4 * kept + 1);
  search->runs = search->extremes ? KM_NEW(km_sample_run, n + 1) : NULL;
  if (!search->probe_n || (search->extremes && !search->runs))
    return false;
  search->probe_d = search->probe_n + n;
  search->first.n = search->probe_d + n;
  search->first.d = search->first.n + kept;
  search->last.n = search->first.d + kept;
  search->last.d = search->last.n + kept;
  return true;
}

void km_event_search_free(km_event_search *search) {
  km_sample_window_free(&search->window);
  km_free(search->probe_n);
  km_free(search->runs);
  km_free(search->changes);
}

void km_event_search_set_count(km_event_search *search, int count) {
  search->count = count;
  search->window.width = 2 * (size_t)count;
}

void km_event_search_restart(km_event_search *search) {
  km_sample_window_clear(&search->window);
}

void km_event_search_restart_at_row(km_event_search *search) {
  search->window.last = -1;
}

km_status km_events_add(km_events *events, km_event event, km_error *error) {
  void *items = events->items;
  if (!km_reserve(&items, &events->capacity, events->count + 1, sizeof event))
    return km_no_sweep_memory(error);
  events->items = items;
  events->items[events->count++] = event;
  return KM_OK;
}

void km_events_sort(km_events *events, const km_sweep_plan *plan) {
  const double sense = km_sweep_sense(plan);
  km_event *e = events->items;
  for (size_t i = 1; i < events->count; ++i)
    for (size_t k = i; k > 0 && sense * (e[k - 1].s - e[k].s) > km_same_position * (1.0 + fabs(e[k].s)); --k) {
      km_event swap = e[k];
      e[k] = e[k - 1];
      e[k - 1] = swap;
    }
}

static void evaluate(const km_event_search *search, km_sweeper *r, double *n, double *d) {
  for (int i = 0; i < search->count; ++i)
    d[i] = 1.0;
  search->values(search->self, r, n, d);
}

bool km_event_search_probe(km_event_search *search, km_sweeper *r, double s) {
  r->is_batched = false; /* the motion is single from here on */
  if (!r->mover.probe(r->mover.self, s, r->rates))
    return false;
  search->is_probing = true;
  evaluate(search, r, search->probe_n, search->probe_d);
  search->is_probing = false;
  return true;
}

static bool has_value(const km_event_search *search, int sample, int i) {
  return sample >= 0 && isfinite(km_sampled_numerator(search, sample, i)) &&
         isfinite(km_sampled_denominator(search, sample, i));
}

bool km_event_search_has_sample(const km_event_search *search) {
  return search->window.row >= 0;
}

double km_event_numerator(const km_event_search *search, int i, int back) {
  int sample = back ? search->window.last : search->window.row;
  return sample < 0 ? nan("") : km_sampled_numerator(search, sample, i);
}

double *km_event_search_step(km_event_search *search, double s) {
  double *n = km_sample_window_step(&search->window, s);
  for (int i = 0; i < search->count && n; ++i)
    n[search->count + i] = 1.0;
  return n;
}

/* Adds a sample to a run and finds the extremum that it completes. The first of equal samples counts, as on both
 * sides of an extremum. */
static km_status add_run_sample(km_event_search *search, km_sweeper *r, int i, double s, double f, bool *is_moved,
                                km_error *error) {
  km_sample_run *run = &search->runs[i];
  if (run->have > 0 && fabs(f - run->f[0]) <= km_relative_zero * (fabs(f) + fabs(run->f[0])))
    return KM_OK;
  memmove(run->s + 1, run->s, 2 * sizeof *run->s);
  memmove(run->f + 1, run->f, 2 * sizeof *run->f);
  run->s[0] = s;
  run->f[0] = f;
  run->have = run->have < 3 ? run->have + 1 : 3;
  if (run->have < 3)
    return KM_OK;
  bool peak = run->f[1] > run->f[2] && run->f[1] > run->f[0], valley = run->f[1] < run->f[2] && run->f[1] < run->f[0];
  *is_moved = *is_moved || peak || valley;
  return peak || valley ? km_event_find_extremum(search, r, i, peak ? -1.0 : 1.0, error) : KM_OK;
}

/* Returns sample position k between s and a pole, from the farthest to the nearest, or (away) in reverse. */
static double pole_sample(double s, double pole, bool away, int k) {
  return pole + (s - pole) * ldexp(1.0, away ? k - POLE_SAMPLES : -1 - k);
}

/* Samples from s to a pole, or away from it: into the run of function i (-1: none), and by `between`. */
static km_status sample_towards_pole(km_event_search *search, km_sweeper *r, int i, double s, double pole, bool away,
                                     bool is_sampled, km_error *error) {
  km_status status = KM_OK;
  bool is_moved = false, extends_run = search->extremes && i >= 0, calls_between = search->between && !is_sampled;
  for (int k = 0; k < POLE_SAMPLES && (extends_run || calls_between) && !status; ++k) {
    double x = pole_sample(s, pole, away, k);
    if (!km_event_search_probe(search, r, x))
      continue;
    if (calls_between && !search->between(search->self, r, x))
      return km_no_sweep_memory(error);
    if (extends_run && isfinite(search->probe_n[i] / search->probe_d[i]))
      status = add_run_sample(search, r, i, x, search->probe_n[i] / search->probe_d[i], &is_moved, error);
  }
  return status;
}

km_status km_event_search_approach_pole(km_event_search *search, km_sweeper *r, double s, double pole, bool away,
                                        km_error *error) {
  return sample_towards_pole(search, r, -1, s, pole, away, false, error);
}

/* Samples both sides of a pole between the last two samples; the run ends at the pole and a new one begins. */
static km_status sample_around_pole(km_event_search *search, km_sweeper *r, int i, double pole, km_error *error) {
  const km_sample_window *w = &search->window;
  km_status status = KM_OK;
  bool is_sampled = pole == search->sampled_pole;
  for (int away = 0; away < 2 && !status; ++away) {
    double s = w->s[away ? w->row : w->last];
    if (s == pole)
      continue;
    if (away)
      search->runs[i].have = 0;
    status = sample_towards_pole(search, r, i, s, pole, away, is_sampled, error);
    if (!away)
      search->runs[i].have = 0;
  }
  search->sampled_pole = pole;
  return status;
}

/* Adds the event of a sample that is itself a zero or a pole of function i. */
static km_status add_event_at_sample(km_event_search *search, int sample, int i, km_error *error) {
  double n = km_sampled_numerator(search, sample, i), d = km_sampled_denominator(search, sample, i);
  bool has_previous = sample > 0 && search->window.last >= 0;
  bool is_zero = n == 0.0 && !(has_previous && km_sampled_numerator(search, sample - 1, i) == 0.0);
  bool pole = d == 0.0 && !(has_previous && km_sampled_denominator(search, sample - 1, i) == 0.0);
  if (!is_zero && !pole)
    return KM_OK;
  km_event_kind kind = n == 0.0 && d == 0.0 ? KM_EVENT_UNDEFINED : pole ? KM_EVENT_POLE : KM_EVENT_ZERO;
  return km_events_add(search->events, (km_event){kind, i, search->window.s[sample], pole ? HUGE_VAL : 0.0}, error);
}

/* Begins the search at the first change of sign that is left. */
static void begin_search(km_event_search *search) {
  const km_sign_change *change = &search->changes[search->next_change];
  km_root_search_begin(&search->root, change->a, change->b, change->fa, change->fb);
}

/* Stores a change of sign for km_event_search_next_probe. */
static km_status defer_zero(km_event_search *search, km_sign_change change, km_error *error) {
  void *changes = search->changes;
  if (!km_reserve(&changes, &search->change_capacity, search->change_count + 1, sizeof change))
    return km_no_sweep_memory(error);
  search->changes = changes;
  search->changes[search->change_count++] = change;
  if (search->change_count == 1)
    begin_search(search);
  return KM_OK;
}

/* Finds zeros and poles of function i between two neighbouring samples; *pole: its position, NaN if there is none. */
static km_status find_events_between(km_event_search *search, km_sweeper *r, int sample, int i, double *pole,
                                     bool *is_moved, km_error *error) {
  const double a = search->window.s[sample], b = search->window.s[sample + 1];
  const double n[2] = {km_sampled_numerator(search, sample, i), km_sampled_numerator(search, sample + 1, i)};
  const double d[2] = {km_sampled_denominator(search, sample, i), km_sampled_denominator(search, sample + 1, i)};
  km_status status = KM_OK;
  bool undefined = false;
  double root;
  if (n[0] * n[1] < 0.0 && search->defers)
    return defer_zero(search, (km_sign_change){i, a, b, n[0], n[1]}, error);
  *is_moved = *is_moved || n[0] * n[1] < 0.0 || d[0] * d[1] < 0.0;
  if (d[0] * d[1] < 0.0 && km_event_find_root(search, r, i, KM_DENOMINATOR, a, b, d[0], d[1], &root) &&
      km_event_vanishes(search->probe_d[i], d[0], d[1])) {
    undefined = km_event_vanishes(search->probe_n[i], n[0], n[1]);
    *pole = undefined ? *pole : root; /* n and d vanish together: the quotient is continuous, and rounding nearby */
    status = km_events_add(
        search->events, (km_event){undefined ? KM_EVENT_UNDEFINED : KM_EVENT_POLE, i, root, undefined ? 0.0 : HUGE_VAL},
        error);
  }
  if (n[0] * n[1] < 0.0 && !status && !undefined &&
      km_event_find_root(search, r, i, KM_NUMERATOR, a, b, n[0], n[1], &root) &&
      km_event_vanishes(search->probe_n[i], n[0], n[1]))
    status = km_events_add(search->events, (km_event){KM_EVENT_ZERO, i, root, 0.0}, error);
  return status;
}

/* Finds zeros and poles of function i at the samples behind the previous row, and between them. */
static km_status find_zeros_and_poles(km_event_search *search, km_sweeper *r, int i, bool *is_moved, km_error *error) {
  const km_sample_window *w = &search->window;
  km_status status = KM_OK;
  double pole = nan("");
  for (int k = w->last < 0 ? w->row : w->last + 1; k <= w->row && !status; ++k) {
    status = add_event_at_sample(search, k, i, error);
    if (status || !has_value(search, w->last < 0 ? -1 : k - 1, i))
      continue;
    status = find_events_between(search, r, k - 1, i, &pole, is_moved, error);
    bool here = km_sampled_denominator(search, k, i) == 0.0, before = km_sampled_denominator(search, k - 1, i) == 0.0;
    pole = here && !before ? w->s[k] : before && !here ? w->s[k - 1] : pole;
  }
  if (isnan(pole) || status)
    return status;
  *is_moved = true;
  return sample_around_pole(search, r, i, pole, error);
}

/* Finds the events of function i at the newest row and since the one before. */
static km_status find_events(km_event_search *search, km_sweeper *r, int i, bool *is_moved, km_error *error) {
  const int row = search->window.row;
  km_status status = KM_OK;
  if (search->extremes && (!has_value(search, row, i) || !has_value(search, search->window.last, i)))
    search->runs[i].have = 0;
  if (!has_value(search, row, i))
    return KM_OK;
  if (search->ratios)
    status = find_zeros_and_poles(search, r, i, is_moved, error);
  if (search->dips && !status && !r->is_passed_row)
    status = km_event_find_dips(search, r, i, is_moved, error);
  double n = km_sampled_numerator(search, row, i), d = km_sampled_denominator(search, row, i);
  return status || d == 0.0 || !search->extremes
             ? status
             : add_run_sample(search, r, i, search->window.s[row], n / d, is_moved, error);
}

/* Returns to the row after probes. */
static void return_to_row(km_sweeper *r) {
  r->mover.restore(r->mover.self);
  km_sweeper_update_motions(r);
}

km_status km_event_search_sample(km_event_search *search, km_sweeper *r, double s, km_error *error) {
  km_sample_window *w = &search->window;
  if (!search->events || search->count == 0)
    return KM_OK;
  if (w->last >= 0 && (s - w->s[w->row]) * (w->s[w->row] - w->s[w->last]) <= 0.0)
    return KM_OK; /* this interval was searched before */
  double *n = km_sample_window_row(w, s);
  if (!n || w->failed)
    return km_no_sweep_memory(error);
  evaluate(search, r, n, n + search->count);
  if (search->sampled)
    search->sampled(search->self, r);
  if (search->ends)
    km_event_record_end_sample(search);
  bool is_moved = false;
  km_status status = KM_OK;
  search->change_count = search->next_change = 0;
  for (int i = 0; i < search->count && !status; ++i)
    status = find_events(search, r, i, &is_moved, error);
  if (is_moved)
    return_to_row(r);
  if (!status && r->mover.pass && !r->mover.pass(r->mover.self))
    status = km_no_sweep_memory(error);
  return status;
}

bool km_event_search_next_probe(km_event_search *search, double *s) {
  *s = search->root.root;
  return search->next_change < search->change_count;
}

km_status km_event_search_probed(km_event_search *search, km_sweeper *r, bool is_reached, km_error *error) {
  const int function = search->changes[search->next_change].function;
  search->is_probing = true;
  if (is_reached)
    evaluate(search, r, search->probe_n, search->probe_d);
  search->is_probing = false;
  if (is_reached)
    km_root_search_update(&search->root, search->probe_n[function]);
  if (is_reached && search->root.open)
    return KM_OK;
  km_status status = km_events_add(search->events, (km_event){KM_EVENT_ZERO, function, search->root.root, 0.0}, error);
  if (++search->next_change < search->change_count)
    begin_search(search);
  return status;
}
