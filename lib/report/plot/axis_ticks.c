/* Round ticks for a range of numbers, and their labels. */
#include "report/plot/axis_ticks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double value_limit = 1e300, value_least = 1e-290;
static const double tick_slack = 1e-6; /* unit: steps; a tick on the border is inside */

bool km_axis_takes(double value) {
  return fabs(value) <= value_limit;
}

double km_axis_limited(double value) {
  return fmax(-value_limit, fmin(value, value_limit));
}

void km_axis_widen(double *low, double *high) {
  if (*low > *high) {
    *low = 0;
    *high = 1;
    return;
  }
  double size = fmax(fabs(*low), fabs(*high));
  if (*high - *low > 1e-9 * size && *high - *low > value_least)
    return;
  double half = size > value_least ? 0.5 * size : 0.5;
  *low -= half;
  *high += half;
}

/* count * 10^exponent, rounded once where 10^|exponent| is exact. */
static double scaled(double count, int exponent) {
  return exponent < 0 ? count / pow(10, -exponent) : count * pow(10, exponent);
}

bool km_axis_in_degrees(const char *label) {
  static const char unit[] = "(deg)";
  size_t length = label ? strlen(label) : 0;
  return length >= sizeof unit - 1 && strcmp(label + length - (sizeof unit - 1), unit) == 0;
}

/* The smallest part or multiple of a circle that is no less; false where powers of ten are as good. */
static bool choose_degrees(km_axis *axis, double least) {
  static const int steps[] = {15, 30, 45, 90, 180, 360, 720, 1800, 3600};
  axis->exponent = 0;
  for (size_t i = 0; least > 10 && i < sizeof steps / sizeof *steps; i++) {
    axis->mantissa = steps[i];
    if (steps[i] >= least)
      return true;
  }
  return false;
}

static void choose_step(km_axis *axis, size_t most, bool degrees) {
  static const int mantissas[] = {1, 2, 5};
  double least = (axis->high - axis->low) / (double)(most ? most : 1) * (1 - tick_slack);
  if (degrees && choose_degrees(axis, least))
    return;
  axis->exponent = (int)floor(log10(least));
  for (size_t i = 0; i < 3; i++) {
    axis->mantissa = mantissas[i];
    if (scaled(axis->mantissa, axis->exponent) >= least)
      return;
  }
  axis->mantissa = 1;
  axis->exponent++;
}

/* Thousands, millions, ... and thousandths, millionths, ... are left out of long labels. */
static int choose_multiplier(const km_axis *axis) {
  int order = (int)floor(log10(fmax(fabs(axis->low), fabs(axis->high))) + tick_slack);
  if (order >= -3 && order <= 4)
    return 0;
  int multiplier = 3 * (int)floor(order / 3.0);
  /* A narrow range far from zero: 1000000002 says more than 1.000000002. */
  bool narrow = multiplier - axis->exponent > 6;
  return narrow && order > 0 && order < 12 ? 0 : multiplier;
}

km_axis km_axis_fit(double low, double high, size_t most, bool degrees, bool round_ends) {
  km_axis axis = {.low = low, .high = high};
  choose_step(&axis, most, degrees);
  double step = scaled(axis.mantissa, axis.exponent);
  double first = round_ends ? floor(low / step + tick_slack) : ceil(low / step - tick_slack);
  double last = round_ends ? ceil(high / step - tick_slack) : floor(high / step + tick_slack);
  axis.first = (long long)first;
  axis.count = last < first ? 0 : (size_t)(last - first) + 1;
  if (round_ends) {
    axis.low = km_axis_tick(&axis, 0);
    axis.high = km_axis_tick(&axis, axis.count - 1);
  }
  axis.multiplier = choose_multiplier(&axis);
  return axis;
}

double km_axis_tick(const km_axis *axis, size_t index) {
  return scaled((double)(axis->first + (long long)index) * axis->mantissa, axis->exponent);
}

/* From integers, so that neither rounding nor the locale's decimal point gets in. */
void km_axis_label(const km_axis *axis, size_t index, char out[KM_AXIS_LABEL]) {
  long long count = (axis->first + (long long)index) * axis->mantissa;
  if (count == 0) {
    strcpy(out, "0");
    return;
  }
  int shift = axis->exponent - axis->multiplier;
  int decimals = shift < 0 ? -shift : 0;
  for (; shift > 0; shift--)
    count *= 10;
  char digits[KM_AXIS_LABEL / 2];
  int length = snprintf(digits, sizeof digits, "%0*lld", decimals + 1, llabs(count));
  snprintf(out, KM_AXIS_LABEL, "%s%.*s%s%s", count < 0 ? "−" : "", length - decimals, digits, decimals ? "." : "",
           digits + length - decimals);
}

void km_axis_multiplier(const km_axis *axis, char out[KM_AXIS_LABEL]) {
  static const char *const superscripts[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  out[0] = 0;
  if (!axis->multiplier)
    return;
  char digits[16];
  snprintf(digits, sizeof digits, "%d", abs(axis->multiplier));
  strcpy(out, axis->multiplier < 0 ? "×10⁻" : "×10");
  for (const char *digit = digits; *digit; digit++)
    strcat(out, superscripts[*digit - '0']);
}
