/* Ranges with round ticks and their labels. Pure arithmetic: it draws nothing. */
#ifndef KM_REPORT_PLOT_AXIS_TICKS_H
#define KM_REPORT_PLOT_AXIS_TICKS_H

#include <stdbool.h>
#include <stddef.h>

/* A longer label (14 digits, sign and point) doesn't arise: see km_axis_widen. */
enum { KM_AXIS_LABEL = 64 };

typedef struct km_axis {
  double low, high;
  int mantissa, exponent; /* ticks are mantissa * 10^exponent apart: mantissa 1, 2 or 5, or whole degrees */
  long long first;        /* tick i is at (first + i) steps */
  size_t count;
  int multiplier; /* labels leave out 10^multiplier; 0 when they are short without it */
} km_axis;

/* True if a value is finite and its difference to another such value is finite. */
bool km_axis_takes(double value);
/* The nearest value that can be drawn. */
double km_axis_limited(double value);
/* Makes a range that can be drawn: an empty one (low > high) becomes 0 to 1, one that is a single
 * value but for round-off (1e-9 of its size) gets half that value to either side. */
void km_axis_widen(double *low, double *high);
/* At most about `most` ticks, round numbers; of degrees above 10 those of a circle: 15, 30, 45, 90, 180, 360, ….
 * `round_ends` moves low and high outward to ticks. */
km_axis km_axis_fit(double low, double high, size_t most, bool degrees, bool round_ends);
/* True if an axis with this label, such as "driver A (deg)", is in degrees; false for NULL. */
bool km_axis_in_degrees(const char *label);

double km_axis_tick(const km_axis *axis, size_t index);
/* "0.25", with as many decimals at every tick, a real minus sign, and "0" for zero. */
void km_axis_label(const km_axis *axis, size_t index, char out[KM_AXIS_LABEL]);
/* Common factor omitted from labels: "×10⁻⁶", or empty. */
void km_axis_multiplier(const km_axis *axis, char out[KM_AXIS_LABEL]);

#endif
