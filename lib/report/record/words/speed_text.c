/* Text about the speed of a driver over its last cycle, and about its place at a time. */
#include "report/record/words/speed_text.h"

#include "history/motion_cycle.h"
#include "kmech/inspect.h"
#include "topology/mechanism.h"

#include <math.h>

static const double constant = 1e-9; /* coefficient of fluctuation of a constant speed, to rounding */

/* A value of more than a cycle, within the cycle; 0 to the accuracy of located peaks. */
static double within(double value, double cycle) {
  static const double accuracy = 1e-7; /* fraction of a cycle */
  const double inside = fabs(value) > cycle * (1.0 + 1e-9) ? value - cycle * floor(value / cycle) : value;
  return fabs(inside) < accuracy * cycle ? 0.0 : inside;
}

void km_speed_words(const km_mechanism *m, const km_table *table, km_text *out) {
  km_driver_speed s;
  if (!km_driver_speed_find(m, table, &s))
    return;
  const km_model *model = m->model;
  const char *unit = km_model_coordinate_unit(model, s.coordinate);
  const double rpm = km_model_coordinate_factor(model, s.coordinate) / model->units.time->si * 60.0 / (2.0 * M_PI);
  km_text_format(out, "%s turns at %.5g rpm", km_model_coordinate_label(model, s.coordinate), rpm * s.mean);
  if (s.fluctuation > constant)
    km_text_format(
        out,
        " on average, from %.5g (at %.4g %s) to %.5g (at %.4g %s); coefficient of fluctuation %.4g, over the "
        "last %.5g %s",
        rpm * s.least, within(s.least_at, s.cycle), unit, rpm * s.greatest, within(s.greatest_at, s.cycle), unit,
        s.fluctuation, s.cycle, unit);
}

void km_place_words(const km_mechanism *m, const km_table *table, int coordinate, double time, km_text *out) {
  const int c = coordinate >= 0 ? coordinate : km_history_driver(m, table);
  km_driver_speed s;
  if (c < 0)
    return;
  double value = km_history_value(table, c, time);
  if (km_driver_speed_find(m, table, &s) && s.coordinate == c)
    value = within(value, s.cycle);
  km_text_format(out, " (%s = %.5g %s)", km_model_coordinate_label(m->model, c), value,
                 km_model_coordinate_unit(m->model, c));
}
