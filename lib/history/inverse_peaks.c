/* Peaks and root mean square of the forces of a prescribed motion, also between rows (docs/theory.md 11.11).
 *
 *   peak : max |f(t)|; a row not below its neighbours brackets a maximum, located on the motion itself, if the parabola
 *          through the three rows can exceed the largest row
 *   rms  : sqrt(1/T integral f^2 dt) by the trapezoidal rule, exact to rounding for smooth forces over a full period */
#include "history/inverse_peaks.h"
#include "base/number/tolerances.h"

#include "base/arguments.h"
#include "base/event_locator.h"
#include "base/table.h"

typedef struct peak_search {
  km_history_writer *w;
  km_inverse_motion *advance_to;
  const km_force_peak *peak;
  size_t row; /* row from which the motion is continued */
} peak_search;

static double magnitude(const double *f, int count) {
  double square = 0.0;
  for (int k = 0; k < count; ++k)
    square += f[k] * f[k];
  return count == 1 ? fabs(f[0]) : sqrt(square);
}

static double magnitude_in_row(const km_history_writer *w, const km_force_peak *peak, size_t row) {
  return magnitude(km_table_row(w->out->table, row) + peak->column, peak->parts);
}

/* Sets the state to a row. */
static km_status set_state_to_row(km_history_writer *w, size_t row) {
  const double *values = km_table_row(w->out->table, row);
  int count = w->m->coordinate_count;
  km_status status = km_state_set_coordinates(w->m, w->state, values + 1, NULL);
  for (int c = 0; c < count; ++c)
    w->state->rate[c] = values[1 + count + c] * km_model_coordinate_factor(w->m->model, c);
  w->state->time = values[0];
  return status ? status : km_dynamics_accelerate(w->dynamics, w->state, NULL);
}

/* Value of the quantity at a time after the row; NaN: the motion can't reach it. */
static double value_at(const peak_search *p, double time) {
  km_history_writer *w = p->w;
  if (set_state_to_row(w, p->row) || p->advance_to(w, time, NULL))
    return nan("");
  if (p->peak->parts == 1)
    return km_dynamics_driving_force(w->dynamics, w->state, p->peak->coordinate);
  return km_vec3_norm(km_dynamics_inertia_forces(w->dynamics).f);
}

/* −|f| at a time, for the minimiser. */
static double negative_magnitude(double time, void *context) {
  return -fabs(value_at(context, time));
}

/* Locates the maximum around row r. */
static void locate_peak(peak_search *p, size_t r, km_force_peak *peak) {
  static const double width = 4e-7; /* relative to the bracket: the error of the peak is 1e-13 */
  const km_history_writer *w = p->w;
  const double *rows[3];
  for (size_t k = 0; k < 3; ++k)
    rows[k] = km_table_row(w->out->table, r + k - 1);
  km_minimum_bracket b = {rows[0][0], -magnitude_in_row(w, peak, r - 1), rows[1][0], -magnitude_in_row(w, peak, r),
                          rows[2][0], -magnitude_in_row(w, peak, r + 1)};
  km_locate_minimum(negative_magnitude, p, width * (b.high - b.low), -HUGE_VAL, &b);
  if (-b.f > fabs(peak->value)) {
    peak->time = b.s;
    peak->value = value_at(p, b.s);
  }
}

/* Height above b of the vertex of the parabola through three equidistant values a ≤ b ≥ c. */
static double parabola_rise(double a, double b, double c) {
  double curvature = 2.0 * b - a - c, slope = 0.5 * (c - a);
  return curvature > 0.0 ? 0.5 * slope * slope / curvature : 0.0;
}

/* Peak and root mean square of one force: the largest row, then the brackets that can exceed it. */
static void find_peak(km_history_writer *w, km_inverse_motion *advance_to, km_force_peak *peak) {
  const km_table *table = w->out->table;
  size_t rows = km_table_rows(table), most = 0;
  double square = 0.0;
  for (size_t r = 0; r < rows; ++r) {
    double size = magnitude_in_row(w, peak, r);
    most = size > magnitude_in_row(w, peak, most) ? r : most;
    if (r > 0)
      square += 0.5 * (km_table_row(table, r)[0] - km_table_row(table, r - 1)[0]) *
                (size * size + pow(magnitude_in_row(w, peak, r - 1), 2.0));
  }
  const double *row = km_table_row(table, most);
  double largest = magnitude_in_row(w, peak, most), span = km_table_row(table, rows - 1)[0];
  peak->rms = span > 0.0 ? sqrt(square / span) : largest;
  peak->value = peak->parts == 1 ? row[peak->column] : largest;
  peak->time = row[0];
  for (size_t r = 1; r + 1 < rows; ++r) {
    double a = magnitude_in_row(w, peak, r - 1), b = magnitude_in_row(w, peak, r), c = magnitude_in_row(w, peak, r + 1);
    double above = parabola_rise(a, b, c);
    if (a > b || c > b || above <= km_solved_rounding * b || b + 2.0 * above < largest)
      continue;
    peak_search p = {w, advance_to, peak, r - 1};
    locate_peak(&p, r, peak);
  }
}

km_status km_inverse_find_peaks(km_history_writer *w, km_inverse_motion *advance_to, km_error *error) {
  km_history *h = w->out;
  km_span driven = km_table_span(h->table, "f."), shaking = km_table_span(h->table, "shaking.");
  size_t rows = km_table_rows(h->table);
  h->peaks = KM_NEW(km_force_peak, driven.count + 1);
  if (!h->peaks)
    return km_fail(error, KM_MEMORY, "out of memory for the largest forces");
  size_t next = driven.first;
  for (int c = 0; c < w->m->coordinate_count; ++c)
    if (w->dynamics->driven[c])
      h->peaks[h->peak_count++] = (km_force_peak){.coordinate = c, .column = next++, .parts = 1};
  h->peaks[h->peak_count++] = (km_force_peak){.coordinate = -1, .column = shaking.first, .parts = 3};
  for (int i = 0; i < h->peak_count; ++i)
    find_peak(w, advance_to, &h->peaks[i]);
  set_state_to_row(w, rows - 1);
  return KM_OK;
}
