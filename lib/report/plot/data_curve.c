/* Lines of data for the page: mapped, cut to the frame, and thinned to what can be seen. */
#include "report/plot/data_curve.h"

#include "report/plot/axis_ticks.h"

#include <math.h>

static const double tolerance = 0.05; /* points */
/* Data on the border, but for round-off, are in the frame. */
static const double slack = 0.01;

/* Zhao and Saalfeld's sleeve: points are passed over as long as one direction from `anchor` comes
 * within the tolerance of all of them and they move on outward. */
typedef struct sleeve {
  km_curve *curve;
  km_canvas_point anchor, last;
  bool open, pending; /* pending: `last` isn't drawn yet */
  double reach;       /* distance from the anchor; 0 until a direction is known */
  double base, low, high;
} sleeve;

km_canvas_point km_frame_map(const km_frame *frame, double x, double y) {
  double across = x / (frame->x_high - frame->x_low) - frame->x_low / (frame->x_high - frame->x_low);
  double up = y / (frame->y_high - frame->y_low) - frame->y_low / (frame->y_high - frame->y_low);
  return (km_canvas_point){frame->left + across * frame->width, frame->top + (1 - up) * frame->height};
}

static void emit(sleeve *s, km_canvas_point point) {
  s->curve->points[s->curve->count++] = point;
  s->anchor = point;
  s->pending = false;
  s->reach = 0;
}

static void close_run(sleeve *s) {
  if (!s->open)
    return;
  if (s->pending)
    emit(s, s->last);
  s->curve->run_ends[s->curve->run_count++] = s->curve->count;
  s->open = false;
}

/* True if `point` can replace `last` as the end of the segment within the tolerance sleeve; then narrows the sleeve. */
static bool extend(sleeve *s, km_canvas_point point) {
  double dx = point.x - s->anchor.x, dy = point.y - s->anchor.y;
  double distance = hypot(dx, dy);
  if (distance <= tolerance)
    return s->reach <= tolerance;
  double angle = atan2(dy, dx), width = asin(tolerance / distance);
  if (s->reach <= 0) {
    s->base = angle;
    s->low = -width;
    s->high = width;
  }
  double turn = remainder(angle - s->base, 2 * acos(-1));
  if (distance < s->reach || turn < s->low || turn > s->high)
    return false;
  s->low = fmax(s->low, turn - width);
  s->high = fmin(s->high, turn + width);
  s->reach = distance;
  return true;
}

static void add(sleeve *s, km_canvas_point point) {
  if (!s->open) {
    emit(s, point);
    s->open = true;
    return;
  }
  if (!extend(s, point)) {
    emit(s, s->last);
    extend(s, point);
  }
  s->last = point;
  s->pending = true;
}

/* Cuts the line a-b to the frame's height; false when nothing is left. */
static bool cut(const km_frame *frame, km_canvas_point *a, km_canvas_point *b) {
  double borders[2] = {frame->top - slack, frame->top + frame->height + slack};
  for (int i = 0; i < 2; i++) {
    double inward = i ? -1 : 1;
    double from = inward * (a->y - borders[i]), to = inward * (b->y - borders[i]);
    if (from < 0 && to < 0)
      return false;
    km_canvas_point *outside = from < 0 ? a : b;
    if (from >= 0 && to >= 0)
      continue;
    double part = from / (from - to);
    *outside = (km_canvas_point){a->x + part * (b->x - a->x), borders[i]};
  }
  return true;
}

static bool inside(const km_frame *frame, km_canvas_point point) {
  return point.y >= frame->top - slack && point.y <= frame->top + frame->height + slack;
}

static void add_segment(sleeve *s, const km_frame *frame, km_canvas_point from, km_canvas_point to) {
  km_canvas_point a = from, b = to;
  if (!cut(frame, &a, &b)) {
    close_run(s);
    return;
  }
  if (!s->open)
    add(s, a);
  add(s, b);
  if (!inside(frame, to))
    close_run(s);
}

static bool drawable(const km_plot_series *series, size_t i) {
  return km_axis_takes(series->x[i]) && km_axis_takes(series->y[i]);
}

static double into_frame(const km_frame *frame, double y) {
  return fmin(fmax(y, frame->top), frame->top + frame->height);
}

static void find_end(km_curve *curve, const km_frame *frame, const km_plot_series *series) {
  const double way_back = 8; /* points: far enough for coincident ends to have parted */
  for (size_t i = series->count; i-- > 0;) {
    if (!drawable(series, i))
      continue;
    km_canvas_point point = km_frame_map(frame, series->x[i], series->y[i]);
    point.y = into_frame(frame, point.y);
    if (!curve->has_end)
      curve->end = point;
    curve->has_end = true;
    curve->before = point.y;
    if (hypot(point.x - curve->end.x, point.y - curve->end.y) > way_back)
      return;
  }
}

km_curve km_curve_make(const km_frame *frame, const km_plot_series *series, km_arena *arena) {
  /* A segment cut at both ends gives two points, and a run is at least one datum. */
  km_curve curve = {.points = KM_ARENA_NEW(arena, km_canvas_point, 2 * series->count + 1),
                    .run_ends = KM_ARENA_NEW(arena, size_t, series->count + 1)};
  if (arena->failed)
    return (km_curve){0};
  sleeve s = {.curve = &curve};
  bool joined = false;
  km_canvas_point previous = {0, 0};
  for (size_t i = 0; i < series->count; i++) {
    if (!drawable(series, i)) {
      close_run(&s);
      joined = false;
      continue;
    }
    km_canvas_point point = km_frame_map(frame, series->x[i], series->y[i]);
    if (joined)
      add_segment(&s, frame, previous, point);
    else if (inside(frame, point))
      add(&s, point);
    previous = point;
    joined = true;
  }
  close_run(&s);
  find_end(&curve, frame, series);
  return curve;
}

static bool crosses(km_canvas_point a, km_canvas_point b, double left, double top, double right, double bottom) {
  if (fmax(a.x, b.x) < left || fmin(a.x, b.x) > right || fmax(a.y, b.y) < top || fmin(a.y, b.y) > bottom)
    return false;
  /* The corners' sides of the line: all on one side means no contact. */
  double dx = b.x - a.x, dy = b.y - a.y;
  double corners[4] = {dx * (top - a.y) - dy * (left - a.x), dx * (top - a.y) - dy * (right - a.x),
                       dx * (bottom - a.y) - dy * (left - a.x), dx * (bottom - a.y) - dy * (right - a.x)};
  double least = fmin(fmin(corners[0], corners[1]), fmin(corners[2], corners[3]));
  double most = fmax(fmax(corners[0], corners[1]), fmax(corners[2], corners[3]));
  return least <= 0 && most >= 0;
}

size_t km_curve_hits(const km_curve *curve, double left, double top, double right, double bottom) {
  size_t hits = 0, begin = 0;
  for (size_t r = 0; r < curve->run_count; r++) {
    for (size_t i = begin + 1; i < curve->run_ends[r]; i++)
      hits += crosses(curve->points[i - 1], curve->points[i], left, top, right, bottom);
    begin = curve->run_ends[r];
  }
  return hits;
}
