/* Joint limits without a stop that a motion over time passes. */
#include "history/history_limits.h"
#include "base/number/tolerances.h"

#include "base/arguments.h"
#include "kinematics/state.h"

/* Tolerance of a limit, so that a joint that starts at its limit and returns to it doesn't pass it: this multiple of
 * the integration's error, or rounding of a prescribed motion, in radians and characteristic lengths. */
static bool has_acting_stop(const km_forces *f, int coordinate) {
  for (int i = 0; i < f->stop_count; ++i)
    if (f->stops[i] == coordinate)
      return true;
  return false;
}

km_status km_limits_monitor_begin(km_limit_monitor *w, const km_mechanism *m, const km_forces *forces,
                                  const km_simulation_def *simulation, km_error *error) {
  *w = (km_limit_monitor){.m = m, .slack = km_relative_zero};
  if (simulation) {
    w->slack = fmax(km_relative_zero, km_significant_ratio * (simulation->absolute + simulation->relative));
    w->user_count = simulation->crossing_count;
  }
  w->limit = KM_NEW(km_passed_limit, (size_t)m->coordinate_count + 1);
  w->is_passed = KM_NEW(bool, (size_t)m->coordinate_count + 1);
  w->crossings = KM_NEW(km_crossing, 2 * (size_t)m->coordinate_count + (size_t)w->user_count + 1);
  if (!w->limit || !w->is_passed || !w->crossings)
    return km_fail(error, KM_MEMORY, "out of memory for the limits");
  for (int i = 0; simulation && i < simulation->crossing_count; ++i)
    w->crossings[w->crossing_count++] = simulation->crossings[i];
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (!km_is_limited(m, c) || m->held[c] || has_acting_stop(forces, c))
      continue;
    w->limit[w->count++] = (km_passed_limit){.coordinate = c};
    const double ends[2] = {m->low[c] - w->slack / m->scale[c], m->high[c] + w->slack / m->scale[c]};
    for (int e = 0; e < 2; ++e)
      if (isfinite(ends[e]) && m->ball_of[c] < 0)
        w->crossings[w->crossing_count++] =
            (km_crossing){.coordinate = c, .value = ends[e] / km_model_coordinate_factor(m->model, c)};
  }
  return KM_OK;
}

/* Records coordinates that are beyond their limits in a row. */
void km_limits_row(km_limit_monitor *w, const km_state *s) {
  for (int i = 0; i < w->count; ++i) {
    km_passed_limit *limit = &w->limit[i];
    int c = limit->coordinate;
    double beyond = km_state_excess(s, c), factor = km_model_coordinate_factor(w->m->model, c);
    if (!(fabs(beyond) * w->m->scale[c] > w->slack))
      continue;
    if (!w->is_passed[i]) {
      bool of_ball = w->m->max_ball_angle[c] < HUGE_VAL;
      double value = of_ball ? w->m->max_ball_angle[c] : s->q[c] - beyond;
      *limit = (km_passed_limit){c, beyond > 0.0, value / factor, s->time, 0.0};
      w->is_passed[i] = true;
    }
    limit->beyond = fmax(limit->beyond, fabs(beyond) / factor);
  }
}

bool km_limits_crossed(km_limit_monitor *w, const km_crossing_met *met) {
  if (met->crossing < w->user_count)
    return false;
  const km_crossing *at = &w->crossings[met->crossing];
  double factor = km_model_coordinate_factor(w->m->model, at->coordinate), value = at->value * factor;
  bool upper = value > w->m->high[at->coordinate];
  int i = 0;
  while (w->limit[i].coordinate != at->coordinate)
    ++i;
  km_passed_limit *limit = &w->limit[i];
  if ((met->sense > 0) == upper && (!w->is_passed[i] || met->time < limit->time)) {
    limit->time = met->time;
    limit->upper = upper;
    limit->limit = (upper ? w->m->high[at->coordinate] : w->m->low[at->coordinate]) / factor;
    w->is_passed[i] = true;
  }
  return true;
}

int km_limits_passed_count(const km_limit_monitor *w) {
  int passed = 0;
  for (int i = 0; i < w->count; ++i)
    passed += w->is_passed[i];
  return passed;
}

const km_passed_limit *km_limits_passed(const km_limit_monitor *w, int index) {
  int i = 0;
  for (; !w->is_passed[i] || index > 0; ++i)
    index -= w->is_passed[i];
  return &w->limit[i];
}

void km_limits_monitor_free(km_limit_monitor *w) {
  km_free(w->limit);
  km_free(w->is_passed);
  km_free(w->crossings);
  *w = (km_limit_monitor){0};
}

void km_limits_report(km_limit_monitor *w, km_history *h) {
  h->limits = w->limit;
  for (int i = 0; i < w->count; ++i)
    if (w->is_passed[i])
      h->limits[h->limit_count++] = w->limit[i];
  km_free(w->is_passed);
  km_free(w->crossings);
  *w = (km_limit_monitor){0};
}
