/* Public access to coordinates, rates, accelerations and time, in the model's units. */
#include "base/arguments.h"
#include "kinematics/state.h"

/* Marks pivots and null spaces as stale after a change of coordinates. */
static void invalidate_null_spaces(const km_mechanism *m, km_state *s) {
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_state_invalidate_pivots(s, i);
    s->mobility_is_known[i] = false;
  }
}

km_status km_state_set_coordinates(const km_mechanism *m, km_state *s, const double *values, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(values != NULL, "values", error);
  for (int c = 0; !status && c < m->coordinate_count; ++c)
    if (!isfinite(values[c]))
      status =
          km_fail(error, KM_USAGE, "%g for %s; expected a finite value", values[c], m->model->coordinates[c].label);
  if (status)
    return status;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (!m->held[c])
      s->q[c] = values[c] * km_model_coordinate_factor(m->model, c);
  km_state_set(m, s, s->q);
  invalidate_null_spaces(m, s);
  return KM_OK;
}

/* Checks that a coordinate can be set to a value, or a rate (`what` is "rate "). */
static km_status check_setting(const km_mechanism *m, const km_state *s, int coordinate, const char *what, double value,
                               km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_index(coordinate, m->coordinate_count, "coordinate", error);
  if (status)
    return status;
  const char *label = m->model->coordinates[coordinate].label;
  if (!isfinite(value))
    return km_fail(error, KM_USAGE, "%s%g for %s; expected a finite value", what, value, label);
  if (m->held[coordinate])
    return km_fail(error, KM_USAGE, "joint \"%s\" is held; expected one that is free to move", label);
  return KM_OK;
}

km_status km_state_set_coordinate(const km_mechanism *m, km_state *s, int coordinate, double value, km_error *error) {
  km_status status = check_setting(m, s, coordinate, "", value, error);
  if (status)
    return status;
  s->q[coordinate] = value * km_model_coordinate_factor(m->model, coordinate);
  km_state_set(m, s, s->q);
  invalidate_null_spaces(m, s);
  return KM_OK;
}

km_status km_state_coordinates(const km_mechanism *m, const km_state *s, double *values, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(values != NULL, "place for the values", error);
  for (int c = 0; !status && c < m->coordinate_count; ++c)
    values[c] = km_state_coordinate(s, c);
  return status;
}

double km_state_rate(const km_state *s, int coordinate) {
  if (!s || coordinate < 0 || coordinate >= s->mechanism->coordinate_count)
    return nan("");
  return s->rate[coordinate] / km_model_coordinate_factor(s->mechanism->model, coordinate);
}

double km_state_acceleration(const km_state *s, int coordinate) {
  if (!s || coordinate < 0 || coordinate >= s->mechanism->coordinate_count)
    return nan("");
  return s->acceleration[coordinate] / km_model_coordinate_factor(s->mechanism->model, coordinate);
}

km_status km_state_set_rate(const km_mechanism *m, km_state *s, int coordinate, double rate, km_error *error) {
  km_status status = check_setting(m, s, coordinate, "rate ", rate, error);
  if (status)
    return status;
  s->rate[coordinate] = rate * km_model_coordinate_factor(m->model, coordinate);
  s->rate_source[coordinate] = KM_RATE_CALLER;
  return KM_OK;
}

double km_state_time(const km_state *s) {
  return s ? s->time : nan("");
}

km_status km_state_set_time(const km_mechanism *m, km_state *s, double time, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status && !isfinite(time))
    status = km_fail(error, KM_USAGE, "time %g; expected a finite value", time);
  if (!status)
    s->time = time;
  return status;
}
