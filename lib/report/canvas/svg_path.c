/* Writes the data of SVG paths. */
#include "report/canvas/svg_path.h"

#include <math.h>

static const double scales[] = {1, 10, 100, 1000, 1e4, 1e5, 1e6};

enum { NUMBER = 32 }; /* bytes of a number at most */

/* Digits from behind, without zeros at the end of the decimals nor one before the point. */
static void write_steps(km_text *out, long long steps, int decimals) {
  char text[NUMBER], *at = text + NUMBER;
  unsigned long long size = steps < 0 ? 0ULL - (unsigned long long)steps : (unsigned long long)steps;
  bool some = false;
  for (int i = 0; i < decimals; ++i, size /= 10)
    if (some || size % 10) {
      *--at = (char)('0' + size % 10);
      some = true;
    }
  if (some)
    *--at = '.';
  for (; size || at == text + NUMBER; size /= 10)
    *--at = (char)('0' + size % 10);
  if (steps < 0)
    *--at = '-';
  km_text_bytes(out, at, (size_t)(text + NUMBER - at));
}

void km_svg_number(km_text *out, double value, int decimals) {
  write_steps(out, llround(value * scales[decimals]), decimals);
}

/* A sign parts two numbers as well as a blank. */
static void add_number(km_svg_path *p, long long steps, bool first) {
  if (!first && steps >= 0)
    km_text_add(p->out, " ");
  write_steps(p->out, steps, p->decimals);
}

static void begin_command(km_svg_path *p, char command) {
  const char text[] = {command, '\0'};
  if (p->last != command)
    km_text_add(p->out, text);
  p->last = command;
}

static void add_points(km_svg_path *p, char command, const km_canvas_point *points, int count) {
  long long x = p->x, y = p->y;
  bool repeated = p->last == command;
  begin_command(p, command);
  for (int i = 0; i < count; ++i) {
    x = llround(points[i].x * scales[p->decimals]);
    y = llround(points[i].y * scales[p->decimals]);
    add_number(p, x - p->x, i == 0 && !repeated);
    add_number(p, y - p->y, false);
  }
  p->x = x;
  p->y = y;
}

static double distance_to_line(km_canvas_point p, km_canvas_point a, km_canvas_point b) {
  double x = b.x - a.x, y = b.y - a.y, square = x * x + y * y;
  double part = square > 0.0 ? fmin(fmax(((p.x - a.x) * x + (p.y - a.y) * y) / square, 0.0), 1.0) : 0.0;
  return hypot(p.x - a.x - part * x, p.y - a.y - part * y);
}

static bool passes_held(const km_svg_path *p, km_canvas_point to) {
  for (int i = 0; i < p->held_count; ++i)
    if (distance_to_line(p->held[i], p->kept, to) > p->slack)
      return false;
  return p->held_count < KM_SVG_HELD;
}

void km_svg_path_end(km_svg_path *p) {
  if (p->held_count == 0)
    return;
  p->kept = p->held[p->held_count - 1];
  p->held_count = 0;
  add_points(p, 'l', &p->kept, 1);
}

static void add_line(km_svg_path *p, km_canvas_point to) {
  if (!passes_held(p, to))
    km_svg_path_end(p);
  p->held[p->held_count++] = to;
}

static void move(km_svg_path *p, km_canvas_point to) {
  p->x = p->y = 0;
  p->last = '\0';
  add_points(p, 'M', &to, 1);
  p->from_x = p->x;
  p->from_y = p->y;
  p->kept = to;
}

void km_svg_path_add(km_svg_path *p, char command, const km_canvas_point *points) {
  if (command == 'L') {
    add_line(p, points[0]);
    return;
  }
  km_svg_path_end(p);
  if (command == 'Z') {
    begin_command(p, 'z');
    p->x = p->from_x;
    p->y = p->from_y;
  } else if (command == 'M') {
    move(p, points[0]);
  } else {
    int count = km_canvas_path_takes(command);
    add_points(p, command == 'Q' ? 'q' : 'c', points, count);
    p->kept = points[count - 1];
  }
}

void km_svg_path_write(km_text *out, const km_canvas_path *path, int decimals, double slack) {
  km_svg_path written = {.out = out, .decimals = decimals, .slack = slack};
  const km_canvas_point *points = path->points;
  for (size_t i = 0; i < path->command_count; ++i) {
    km_svg_path_add(&written, path->commands[i], points);
    points += km_canvas_path_takes(path->commands[i]);
  }
  km_svg_path_end(&written);
}
