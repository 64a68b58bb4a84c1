/* Draws lines that lie on each other with gaps, so that those beneath stay visible. */
#include "report/plot/overlapping_lines.h"

#include "report/canvas/palette.h"

#include <math.h>

enum { SAMPLES = 64, LEAST_ON = SAMPLES / 2 };

static double way(km_canvas_point a, km_canvas_point b) {
  return hypot(b.x - a.x, b.y - a.y);
}

static double length_of(const km_curve *curve) {
  double length = 0;
  size_t begin = 0;
  for (size_t r = 0; r < curve->run_count; begin = curve->run_ends[r++])
    for (size_t i = begin + 1; i < curve->run_ends[r]; i++)
      length += way(curve->points[i - 1], curve->points[i]);
  return length;
}

static double distance(km_canvas_point p, km_canvas_point a, km_canvas_point b) {
  double x = b.x - a.x, y = b.y - a.y, square = x * x + y * y;
  double t = square > 0 ? fmin(fmax(((p.x - a.x) * x + (p.y - a.y) * y) / square, 0), 1) : 0;
  return hypot(p.x - a.x - t * x, p.y - a.y - t * y);
}

static bool touches(const km_curve *curve, km_canvas_point p, double width) {
  size_t begin = 0;
  for (size_t r = 0; r < curve->run_count; begin = curve->run_ends[r++])
    for (size_t i = begin + 1; i < curve->run_ends[r]; i++)
      if (distance(p, curve->points[i - 1], curve->points[i]) < 0.5 * width)
        return true;
  return false;
}

/* Number of samples, evenly spaced on the upper curve, that lie on the lower curve. */
static int samples_on(const km_curve *upper, const km_curve *lower, double width) {
  double gap = length_of(upper) / SAMPLES, next = 0.5 * gap, passed = 0;
  int on = 0;
  size_t begin = 0;
  for (size_t r = 0; r < upper->run_count && gap > 0; begin = upper->run_ends[r++])
    for (size_t i = begin + 1; i < upper->run_ends[r]; i++) {
      km_canvas_point a = upper->points[i - 1], b = upper->points[i];
      double length = way(a, b);
      for (; next < passed + length; next += gap) {
        double t = (next - passed) / length;
        on += touches(lower, (km_canvas_point){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}, width);
      }
      passed += length;
    }
  return on;
}

km_pen km_overlap_pen(const km_plot_series *series, const km_curve *curves, size_t index, double width) {
  /* The dashes of the second, third and fourth line of a pile leave a part of each one beneath. */
  static const double dashes[][2] = {{7, 5}, {4.5, 7.5}, {2.5, 9.5}};
  enum { MOST = sizeof dashes / sizeof *dashes };
  km_pen pen = km_palette_pen(series[index].colour, series[index].dash, width);
  size_t beneath = 0;
  bool solid = true;
  for (size_t i = 0; i < index && series[index].colour >= 0 && beneath < MOST; i++) {
    if (series[i].colour < 0 || samples_on(&curves[index], &curves[i], width) < LEAST_ON)
      continue;
    solid = solid && km_palette_pen(series[i].colour, series[i].dash, width).dash_count == 0;
    beneath++;
  }
  if (beneath == 0 || (beneath == 1 && solid && pen.dash_count > 0))
    return pen;
  pen.dash = dashes[beneath - 1];
  pen.dash_count = 2;
  return pen;
}
