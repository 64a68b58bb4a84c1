/* Directions out of the actuators' reach. */
#include "statics/statics.h"

#include <math.h>
#include <string.h>

double *km_direction_begin(const km_mechanism *m, bool falls, km_statics *st) {
  if (st->direction_count++ >= KM_MAX_DIRECTIONS)
    return NULL;
  st->falls[st->direction_count - 1] = falls;
  double *rates = st->directions + (size_t)(st->direction_count - 1) * (size_t)m->coordinate_count;
  memset(rates, 0, (size_t)m->coordinate_count * sizeof *rates);
  return rates;
}

void km_direction_end(const km_mechanism *m, const km_actuator_workspace *h, double *rates) {
  double largest = 0.0;
  for (int j = 0; j < h->columns; ++j)
    largest = fmax(largest, fabs(rates[h->coordinate[j]] / m->unit[h->coordinate[j]]));
  for (int j = 0; j < h->columns; ++j)
    rates[h->coordinate[j]] /= largest;
}
