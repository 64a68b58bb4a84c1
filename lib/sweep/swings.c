/* Swings of coordinates along a sweep: extremes over the rows, and at dead points by the cubic through four rows. The
 * slope is 0 there, so that an error of the place doesn't count. */
#include "sweep/sweep.h"

#include "base/table.h"

#include <math.h>

void km_swing_take(km_swing *swing, double value, double s) {
  if (!(value >= swing->low)) {
    swing->low = value;
    swing->s_low = s;
  }
  if (!(value <= swing->high)) {
    swing->high = value;
    swing->s_high = s;
  }
}

/* Lagrange's cubic of a column through the rows around s; the value of a row if there are fewer than four. */
static double value_at(const km_table *t, size_t s_column, size_t column, double s) {
  size_t rows = km_table_rows(t), first = 0;
  double sense = km_table_row(t, rows - 1)[s_column] - km_table_row(t, 0)[s_column];
  while (first + 4 < rows && sense * (km_table_row(t, first + 2)[s_column] - s) < 0.0)
    ++first;
  if (rows < 4)
    return km_table_row(t, 0)[column];
  double sum = 0.0;
  for (size_t i = 0; i < 4; ++i) {
    double weight = 1.0, own = km_table_row(t, first + i)[s_column];
    for (size_t k = 0; k < 4; ++k) {
      double other = km_table_row(t, first + k)[s_column];
      weight *= k == i ? 1.0 : (s - other) / (own - other);
    }
    sum += weight * km_table_row(t, first + i)[column];
  }
  return sum;
}

/* True if a hinge's net travel is a full turn. */
static bool goes_round(const km_mechanism *m, const km_table *t, size_t column, int c) {
  double net = km_table_row(t, km_table_rows(t) - 1)[column] - km_table_row(t, 0)[column];
  return km_coordinate_turns(m, c) && fabs(net) >= 2.0 * M_PI / m->factor[c] * (1.0 - 1e-9);
}

km_swing km_swing_over_rows(const km_mechanism *m, const km_table *t, int coordinate) {
  km_swing swing = {.coordinate = coordinate, .low = nan(""), .high = nan("")};
  int s = km_table_find(t, "s"), q = (int)km_table_span(t, "q.").first + coordinate;
  for (size_t r = 0; r < km_table_rows(t); ++r)
    km_swing_take(&swing, km_table_row(t, r)[q], km_table_row(t, r)[s]);
  swing.goes_round = km_table_rows(t) > 0 && goes_round(m, t, (size_t)q, coordinate);
  return swing;
}

km_swing km_swing_with_toggles(const km_mechanism *m, const km_mobility_sweep *sweep, int coordinate) {
  const km_table *t = sweep->motion.table;
  km_swing swing = km_swing_over_rows(m, t, coordinate);
  size_t s = (size_t)km_table_find(t, "s"), q = km_table_span(t, "q.").first + (size_t)coordinate;
  for (size_t i = 0; i < sweep->toggle_count; ++i)
    if (sweep->toggles[i].coordinate == coordinate)
      km_swing_take(&swing, value_at(t, s, q, sweep->toggles[i].s), sweep->toggles[i].s);
  return swing;
}
