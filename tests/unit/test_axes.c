/* Axes, curves and panels of plots, before anything is drawn: ticks are round and read back, curves keep their data. */
#include "support/support.h"

#include "report/canvas/palette.h"
#include "report/plot/axis_ticks.h"
#include "report/plot/data_curve.h"
#include "report/plot/overlapping_lines.h"
#include "report/plot/plot_layout.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Suppressions for LeakSanitizer: fontconfig and Pango keep their caches until the process ends. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libfontconfig\nleak:libpango\n";
}

/* "−0.25" and "×10⁻⁶" as numbers. */
static double read_label(const km_axis *axis, size_t index) {
  char text[KM_AXIS_LABEL];
  const char minus[] = "−";
  km_axis_label(axis, index, text);
  bool negative = strncmp(text, minus, sizeof minus - 1) == 0;
  double value = strtod(negative ? text + sizeof minus - 1 : text, NULL);
  return (negative ? -value : value) * pow(10.0, axis->multiplier);
}

static int read_multiplier(const km_axis *axis) {
  static const char *const digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  char text[KM_AXIS_LABEL];
  int value = 0, sign = 1;
  km_axis_multiplier(axis, text);
  if (!*text)
    return 0;
  const char *rest = text + strlen("×10");
  if (strncmp(rest, "⁻", 3) == 0) {
    sign = -1;
    rest += 3;
  }
  while (*rest)
    for (int d = 0; d < 10; ++d)
      if (strncmp(rest, digits[d], strlen(digits[d])) == 0) {
        value = 10 * value + d;
        rest += strlen(digits[d]);
        break;
      }
  return sign * value;
}

/* Ticks: 1, 2 or 5 times a power of ten apart, all inside, at most as many as requested and not much fewer. */
static void ticks_are_round_and_read_back(void **state) {
  (void)state;
  randomness r = {7};
  for (int i = 0; i < 20000; ++i) {
    double size = pow(10.0, uniform(&r, -12.0, 12.0)), low = uniform(&r, -1.0, 1.0) * size;
    double high = low + uniform(&r, 0.01, 1.0) * size;
    size_t most = (size_t)(2 + below(&r, 9));
    bool round_ends = below(&r, 2), degrees = below(&r, 2);
    km_axis axis = km_axis_fit(low, high, most, degrees, round_ends);
    double step = axis.mantissa * pow(10.0, axis.exponent), slack = 1e-5 * step;
    bool decimal = axis.mantissa == 1 || axis.mantissa == 2 || axis.mantissa == 5, circle = fmod(step, 15.0) == 0.0;
    assert_true(degrees && step > 10.0 * (1.0 + 1e-9) && step <= 3600.0 ? circle : decimal);
    assert_true((high - low) / step <= (double)most + 1e-5);
    assert_true((high - low) / step >= (double)most / 2.5 - 1e-5); /* the next smaller step would be too small */
    if (round_ends) {
      assert_true(axis.low <= low + slack && axis.low > low - step && axis.high >= high - slack &&
                  axis.high < high + step);
      assert_near(km_axis_tick(&axis, 0), axis.low, 0.0);
      assert_near(km_axis_tick(&axis, axis.count - 1), axis.high, 0.0);
    } else {
      assert_true(axis.low == low && axis.high == high);
      assert_true(km_axis_tick(&axis, 0) >= low - slack && km_axis_tick(&axis, 0) < low + step);
      assert_true(axis.count == 0 || km_axis_tick(&axis, axis.count - 1) <= high + slack);
      assert_true(axis.count == 0 || km_axis_tick(&axis, axis.count - 1) > high - step);
    }
    for (size_t k = 0; k < axis.count; ++k) {
      double tick = km_axis_tick(&axis, k);
      assert_near(tick, (double)(axis.first + (long long)k) * step, 1e-9 * step + 1e-15 * fabs(tick));
      assert_near(read_label(&axis, k), tick, 1e-6 * step + 1e-15 * fabs(tick));
    }
    assert_int_equal(read_multiplier(&axis), axis.multiplier);
    char label[KM_AXIS_LABEL];
    for (size_t k = 0; k < axis.count && fabs(log10(size)) < 8.0 && (high - low) > 1e-3 * size; ++k) {
      km_axis_label(&axis, k, label);
      assert_true(strlen(label) <= 12);
    }
  }
}

static void degrees_tick_by_parts_of_a_circle(void **state) {
  (void)state;
  const double cases[][3] = {/* range from, to, step */
                             {0, 360, 45},   {0, 180, 30}, {-180, 180, 45}, {0, 90, 10}, {0, 40, 5},
                             {180, 540, 45}, {0, 720, 90}, {0, 1.5, 0.2},   {0, 100, 15}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    km_axis axis = km_axis_fit(cases[i][0], cases[i][1], 9, true, false);
    assert_near(km_axis_tick(&axis, 1) - km_axis_tick(&axis, 0), cases[i][2], 1e-12);
  }
  assert_true(km_axis_in_degrees("driver A (deg)") && km_axis_in_degrees("(deg)"));
  assert_false(km_axis_in_degrees("driver A (deg) ") || km_axis_in_degrees("rate (deg/s)") ||
               km_axis_in_degrees("deg)") || km_axis_in_degrees("") || km_axis_in_degrees(NULL));
}

static void ranges_can_be_drawn(void **state) {
  (void)state;
  double cases[][4] = {{1, 0, 0, 1},     {0, 0, -0.5, 0.5}, {4, 4, 2, 6},
                       {-4, -4, -6, -2}, {1, 3, 1, 3},      {1, 1 + 1e-12, 0.5, 1.5}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    double low = cases[i][0], high = cases[i][1];
    km_axis_widen(&low, &high);
    assert_near(low, cases[i][2], 1e-11);
    assert_near(high, cases[i][3], 1e-11);
  }
  assert_true(km_axis_takes(1e299) && km_axis_takes(-1e300) && !km_axis_takes(HUGE_VAL) && !km_axis_takes(-HUGE_VAL) &&
              !km_axis_takes((double)NAN));
}

/* Distance of a point from the segment a-b. */
static double distance(km_canvas_point p, km_canvas_point a, km_canvas_point b) {
  double x = b.x - a.x, y = b.y - a.y, square = x * x + y * y;
  double t = square > 0.0 ? ((p.x - a.x) * x + (p.y - a.y) * y) / square : 0.0;
  t = fmin(fmax(t, 0.0), 1.0);
  return hypot(p.x - a.x - t * x, p.y - a.y - t * y);
}

static double distance_to_curve(const km_curve *curve, km_canvas_point p) {
  double nearest = HUGE_VAL;
  size_t begin = 0;
  for (size_t r = 0; r < curve->run_count; begin = curve->run_ends[r++])
    for (size_t i = begin; i < curve->run_ends[r]; ++i) {
      size_t next = i + 1 < curve->run_ends[r] ? i + 1 : i;
      nearest = fmin(nearest, distance(p, curve->points[i], curve->points[next]));
    }
  return nearest;
}

/* Thinned curves: every datum in the frame lies on the curve, to 0.05 points; every point of the curve is in the frame;
 * gaps part it. */
static void curves_keep_their_data(void **state) {
  (void)state;
  enum { POINTS = 400 };
  randomness r = {11};
  for (int round = 0; round < 300; ++round) {
    double x[POINTS], y[POINTS], slope = 0.0, level = 0.0;
    int gap = below(&r, 3) ? -1 : 1 + below(&r, POINTS - 2);
    for (int i = 0; i < POINTS; ++i) {
      slope = 0.97 * slope + uniform(&r, -0.02, 0.02);
      level += slope;
      x[i] = i / (double)(POINTS - 1);
      y[i] = i == gap ? (double)NAN : level;
    }
    const km_frame frame = {
        .left = 40, .top = 20, .width = 300, .height = 200, .x_low = 0, .x_high = 1, .y_low = -1.0, .y_high = 1.5};
    const km_plot_series series = {.name = "f", .x = x, .y = y, .count = POINTS};
    km_arena arena = {0};
    km_curve curve = km_curve_make(&frame, &series, &arena);
    km_canvas_point last = {0, 0};
    for (int i = 0; i < POINTS; ++i) {
      if (i == gap)
        continue;
      km_canvas_point p = km_frame_map(&frame, x[i], y[i]);
      assert_near(p.x, 40.0 + 300.0 * x[i], 1e-9);
      assert_near(p.y, 220.0 - 200.0 * (y[i] + 1.0) / 2.5, 1e-9 * (1.0 + fabs(y[i])));
      if (y[i] > frame.y_low && y[i] < frame.y_high)
        assert_true(distance_to_curve(&curve, p) <= 0.05 + 1e-9);
      last = p;
    }
    for (size_t i = 0; i < curve.count; ++i) {
      assert_true(curve.points[i].x >= 40.0 - 1e-9 && curve.points[i].x <= 340.0 + 1e-9);
      assert_true(curve.points[i].y >= 20.0 - 0.011 && curve.points[i].y <= 220.0 + 0.011);
    }
    if (gap > 0 && fabs(y[gap - 1]) < 0.9 && fabs(y[gap + 1]) < 0.9) { /* nothing is drawn across the gap */
      km_canvas_point middle = km_frame_map(&frame, x[gap], 0.5 * (y[gap - 1] + y[gap + 1]));
      assert_true(distance_to_curve(&curve, middle) > 0.3);
    }
    assert_true(curve.has_end && curve.end.x == last.x);
    assert_near(curve.end.y, fmin(fmax(last.y, 20.0), 220.0), 1e-9);
    assert_true(curve.count <= POINTS + 4);
    km_arena_free(&arena);
  }
}

/* A straight line needs two points. */
static void straight_lines_are_two_points(void **state) {
  (void)state;
  enum { POINTS = 100 };
  double x[POINTS], y[POINTS];
  for (int i = 0; i < POINTS; ++i)
    y[i] = 2.0 * (x[i] = i / 99.0);
  const km_frame frame = {
      .left = 0, .top = 0, .width = 100, .height = 100, .x_low = 0, .x_high = 1, .y_low = 0, .y_high = 2};
  const km_plot_series series = {.name = "f", .x = x, .y = y, .count = POINTS};
  km_arena arena = {0};
  km_curve curve = km_curve_make(&frame, &series, &arena);
  assert_int_equal(curve.count, 2);
  assert_int_equal(curve.run_count, 1);
  assert_int_equal(km_curve_hits(&curve, 40, 40, 60, 60), 1);
  assert_int_equal(km_curve_hits(&curve, 60, 60, 90, 90), 0);
  km_arena_free(&arena);
}

/* Panels are adjacent within the page, each with its frame, and don't overlap; the y axis includes all data. */
/* The line of y = 0 except y = level for the points from `parted` on, in a frame of 300 x 200 points. */
static km_curve flat_curve(double *y, const double *x, size_t count, size_t parted, double level, km_arena *arena) {
  const km_frame frame = {10.0, 10.0, 300.0, 200.0, 0.0, 1.0, -1.0, 1.0};
  for (size_t i = 0; i < count; ++i)
    y[i] = i < parted ? 0.0 : level;
  const km_plot_series series = {.x = x, .y = y, .count = count};
  return km_curve_make(&frame, &series, arena);
}

static void lines_on_each_other_stay_visible(void **state) {
  (void)state;
  enum { POINTS = 41 };
  double x[POINTS], y[POINTS];
  for (size_t i = 0; i < POINTS; ++i)
    x[i] = (double)i / (POINTS - 1);
  km_arena arena = {0};
  km_plot_series series[4] = {{.colour = 0}, {.colour = 1}, {.colour = 2}, {.colour = 3}};
  km_curve curves[4];
  for (int i = 0; i < 4; ++i)
    curves[i] = flat_curve(y, x, POINTS, POINTS, 0.0, &arena);
  double covered = 0.0;
  for (size_t i = 0; i < 4; ++i) { /* each pen covers less of the period than the pen below it */
    km_pen pen = km_overlap_pen(series, curves, i, 1.3);
    assert_int_equal(pen.dash_count, i ? 2 : 0);
    double drawn = i ? pen.dash[0] / (pen.dash[0] + pen.dash[1]) : 1.0;
    assert_true(i == 0 || drawn < 0.75 * covered);
    covered = drawn;
  }
  curves[1] = flat_curve(y, x, POINTS, 3 * POINTS / 4, 0.5, &arena); /* most of the way together */
  assert_int_equal(km_overlap_pen(series, curves, 1, 1.3).dash_count, 2);
  curves[1] = flat_curve(y, x, POINTS, POINTS / 4, 0.5, &arena); /* apart but for the beginning */
  assert_int_equal(km_overlap_pen(series, curves, 1, 1.3).dash_count, 0);
  curves[1] = curves[0];
  series[1].dash = 1; /* dashes over a solid line show both already */
  assert_true(km_overlap_pen(series, curves, 1, 1.3).dash[0] == km_palette_pen(1, 1, 1.3).dash[0]);
  series[0].dash = 1;
  assert_true(km_overlap_pen(series, curves, 1, 1.3).dash[0] != km_palette_pen(1, 1, 1.3).dash[0]);
  series[0].colour = -1; /* grey lines are below */
  assert_true(km_overlap_pen(series, curves, 1, 1.3).dash[0] == km_palette_pen(1, 1, 1.3).dash[0]);
  km_arena_free(&arena);
}

static void panels_have_room(void **state) {
  (void)state;
  const double x[] = {0, 1, 2}, y[] = {-3, 5, 2};
  const km_plot_series series = {.name = "a line", .x = x, .y = y, .count = 3};
  const km_plot_mark mark = {1.5, "mark", 0};
  for (size_t panels = 1; panels <= 9; ++panels) {
    km_plot_panel panel[9];
    for (size_t i = 0; i < panels; ++i)
      panel[i] =
          (km_plot_panel){.title = "part", .series = &series, .series_count = 1, .marks = &mark, .mark_count = 1};
    const km_plot plot = {
        .title = "t", .subtitle = "s", .x_label = "x", .y_label = "y", .panels = panel, .panel_count = panels};
    double width, height;
    km_text bytes = {0};
    km_canvas *canvas;
    km_arena arena = {0};
    km_plot_layout_size(&plot, &width, &height);
    assert_int_equal(km_canvas_create(KM_PICTURE_SVG, width, height, &bytes, &canvas, NULL), KM_OK);
    km_plot_layout layout = {.plot = &plot, .canvas = canvas, .arena = &arena};
    km_plot_layout_make(&layout, width, height);
    assert_true(layout.fits && layout.columns * layout.rows >= panels && layout.columns * (layout.rows - 1) < panels);
    assert_true(layout.y[0].low <= -3.0 && layout.y[0].high >= 5.0 && layout.x.low <= 0.0 && layout.x.high >= 2.0);
    assert_true(layout.y[0].low >= -6.0 && layout.y[0].high <= 8.0 && layout.x.low == 0.0 && layout.x.high == 2.0);
    for (size_t i = 0; i < panels; ++i) {
      km_frame a = km_plot_layout_frame(&layout, i);
      assert_true(a.left >= 0.0 && a.top >= 0.0 && a.left + a.width <= width && a.top + a.height <= height);
      assert_true(a.width > 60.0 && a.height > 40.0);
      for (size_t k = 0; k < i; ++k) {
        km_frame b = km_plot_layout_frame(&layout, k);
        assert_true(a.left >= b.left + b.width || b.left >= a.left + a.width || a.top >= b.top + b.height ||
                    b.top >= a.top + a.height);
      }
    }
    km_arena_free(&arena);
    km_canvas_free(canvas);
    km_text_free(&bytes);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(ticks_are_round_and_read_back),
                                     cmocka_unit_test(degrees_tick_by_parts_of_a_circle),
                                     cmocka_unit_test(ranges_can_be_drawn),
                                     cmocka_unit_test(curves_keep_their_data),
                                     cmocka_unit_test(straight_lines_are_two_points),
                                     cmocka_unit_test(lines_on_each_other_stay_visible),
                                     cmocka_unit_test(panels_have_room)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
