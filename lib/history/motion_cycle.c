/* Cycles of loads and drivers, and the speed of a driver over its last cycle (motion_cycle.h). */
#include "history/motion_cycle.h"
#include "base/number/tolerances.h"

#include "kmech/inspect.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>

/* Period of a module's law over time (`coordinate` −1) or over the value of one joint; 0: none. */
static double module_period(const km_model_module *module, int *coordinate) {
  const bool reads_joint = module->variable == KM_VARIABLE_DISPLACEMENT && module->input_count == 1 &&
                           module->input.coordinate >= 0 && module->inputs[0].weight == 1.0;
  *coordinate = reads_joint ? module->input.coordinate : -1;
  return reads_joint || module->variable == KM_VARIABLE_TIME ? module->curve.period : 0.0;
}

/* Longest period of the laws over a coordinate, radians or the length unit. */
static double period_over(const km_model *model, int coordinate) {
  double longest = 0.0;
  for (int i = 0; i < model->load_count; ++i) {
    const km_load_scale *scale = model->loads[i].scale;
    if (scale && scale->coordinate == coordinate)
      longest = fmax(longest, scale->curve.period);
  }
  for (int i = 0; i < model->module_count; ++i) {
    int over;
    const double period = module_period(&model->modules[i], &over);
    if (over == coordinate)
      longest = fmax(longest, period);
  }
  return longest;
}

static double rate_of(const km_model *model, int coordinate, const km_constant_rate *rates, int rate_count) {
  for (int i = 0; i < rate_count; ++i)
    if (rates[i].coordinate == coordinate)
      return rates[i].rate;
  return model->coordinates[coordinate].rate_stated ? model->coordinates[coordinate].rate : 0.0;
}

double km_longest_period(const km_model *model, const km_constant_rate *rates, int rate_count, bool *over_joint) {
  double longest = period_over(model, -1);
  *over_joint = false;
  for (int j = 0; j < model->joint_count; ++j) {
    const km_joint_prescribed *p = &model->joints[j].prescribed;
    longest = fmax(longest, p->law == KM_MOTION_FREE ? 0.0 : p->curve.period);
  }
  for (int c = 0; c < model->coordinate_count; ++c) {
    const double rate = fabs(rate_of(model, c, rates, rate_count)) * km_model_coordinate_factor(model, c);
    const double time = rate > 0.0 ? period_over(model, c) / rate : 0.0;
    *over_joint = *over_joint || time > 0.0;
    longest = fmax(longest, time);
  }
  return longest;
}

static double cell(const km_table *t, size_t row, size_t column) {
  return km_table_row(t, row)[column];
}

/* Hermite's cubic between two rows. */
static double between(const km_table *t, size_t row, size_t q, size_t v, double time) {
  const double t0 = cell(t, row, 0), h = cell(t, row + 1, 0) - t0, z = h > 0.0 ? (time - t0) / h : 0.0;
  const double a = cell(t, row, q), b = cell(t, row + 1, q), da = h * cell(t, row, v), db = h * cell(t, row + 1, v);
  return a + z * (da + z * (3.0 * (b - a) - 2.0 * da - db + z * (2.0 * (a - b) + da + db)));
}

double km_history_value(const km_table *t, int coordinate, double time) {
  const size_t q = km_table_span(t, "q.").first + (size_t)coordinate,
               v = km_table_span(t, "v.").first + (size_t)coordinate, rows = km_table_rows(t);
  size_t row = 0;
  while (row + 2 < rows && cell(t, row + 1, 0) <= time)
    ++row;
  return rows > 1 ? between(t, row, q, v, time) : cell(t, 0, q);
}

/* A full turn, or the longest period over the coordinate; its own unit. */
static double cycle_of(const km_mechanism *m, int c) {
  const double factor = km_model_coordinate_factor(m->model, c), period = period_over(m->model, c);
  return (period > 0.0 ? period : 2.0 * M_PI) / factor;
}

/* Time at which the coordinate is `cycle` before its last value; the start where it moves by less. */
static double start_of_cycle(const km_table *t, int c, double cycle) {
  const size_t q = km_table_span(t, "q.").first + (size_t)c, rows = km_table_rows(t);
  const double last = cell(t, rows - 1, q);
  size_t row = rows - 1;
  while (row > 0 && fabs(last - cell(t, row, q)) < cycle)
    --row;
  double low = cell(t, row, 0), high = cell(t, row + 1 < rows ? row + 1 : row, 0);
  if (fabs(last - cell(t, row, q)) <= cycle)
    return low;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    if (fabs(last - km_history_value(t, c, middle)) > cycle)
      low = middle;
    else
      high = middle;
  }
  return high;
}

static bool speed_of(const km_mechanism *m, const km_table *t, int c, km_driver_speed *out) {
  const size_t q = km_table_span(t, "q.").first + (size_t)c, v = km_table_span(t, "v.").first + (size_t)c,
               rows = km_table_rows(t);
  if (!km_coordinate_turns(m, c) || m->held[c] || rows < 2)
    return false;
  *out = (km_driver_speed){.coordinate = c, .cycle = cycle_of(m, c), .least = HUGE_VAL, .greatest = -HUGE_VAL};
  out->from = start_of_cycle(t, c, out->cycle);
  for (size_t r = 0; r < rows; ++r) {
    const double rate = cell(t, r, v);
    if (cell(t, r, 0) < out->from)
      continue;
    if (rate < out->least) {
      out->least = rate;
      out->least_at = cell(t, r, q);
    }
    if (rate > out->greatest) {
      out->greatest = rate;
      out->greatest_at = cell(t, r, q);
    }
  }
  const double moved = cell(t, rows - 1, q) - km_history_value(t, c, out->from);
  const double turn = 2.0 * M_PI / km_model_coordinate_factor(m->model, c);
  out->cycle = fmin(out->cycle, fabs(moved));
  out->mean = moved / (cell(t, rows - 1, 0) - out->from);
  out->fluctuation = (out->greatest - out->least) / fabs(out->mean);
  return fabs(moved) >= (1.0 - km_relative_zero) * turn && out->least * out->greatest > 0.0;
}

static bool is_prescribed(const km_mechanism *m, const km_table *t, int c) {
  char name[512];
  snprintf(name, sizeof name, "f.%s", km_model_coordinate_label(m->model, c));
  return km_table_find(t, name) >= 0;
}

static bool is_on_ground(const km_model *model, int c) {
  const km_model_joint *joint = &model->joints[model->coordinates[c].joint];
  return model->frames[joint->frame[0]].body == 0 || model->frames[joint->frame[1]].body == 0;
}

int km_history_driver(const km_mechanism *m, const km_table *t) {
  km_driver_speed speed;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (is_prescribed(m, t, c))
      return c;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (is_on_ground(m->model, c) && speed_of(m, t, c, &speed))
      return c;
  return -1;
}

bool km_driver_speed_find(const km_mechanism *m, const km_table *t, km_driver_speed *out) {
  const int driver = km_history_driver(m, t);
  return driver >= 0 && speed_of(m, t, driver, out);
}
