/* Writes the data of SVG paths. */
#include "report/plot/svg_path.h"

#include <math.h>
#include <stdio.h>

static const double scales[] = {1, 10, 100, 1000};

static void write_steps(km_text *out, long long steps, int decimals) {
  long long scale = (long long)scales[decimals], size = steps < 0 ? -steps : steps, rest = size % scale;
  if (steps < 0)
    km_text_add(out, "-");
  if (size >= scale || rest == 0)
    km_text_format(out, "%lld", size / scale);
  if (rest == 0)
    return;
  for (; rest % 10 == 0; rest /= 10)
    --decimals;
  km_text_format(out, ".%0*lld", decimals, rest);
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

void km_svg_path_add(km_svg_path *p, char command, const km_canvas_point *points) {
  if (command == 'Z') {
    begin_command(p, 'z');
    p->x = p->from_x;
    p->y = p->from_y;
  } else if (command == 'M') {
    p->x = p->y = 0;
    p->last = '\0';
    add_points(p, 'M', points, 1);
    p->last = 'M';
    p->from_x = p->x;
    p->from_y = p->y;
  } else {
    add_points(p, command == 'L' ? 'l' : 'c', points, command == 'L' ? 1 : 3);
  }
}
