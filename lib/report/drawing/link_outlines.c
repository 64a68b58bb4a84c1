/* Finds the outlines of links, and draws them at true scale. */
#include "report/drawing/link_outlines.h"

#include "report/canvas/palette.h"
#include "report/drawing/drawing_parts.h"

static const double hole = 0.25; /* radius of a hole in link widths */

typedef struct work {
  km_studio studio;
  km_outlines *out;
  size_t capacity;
} work;

static void reach(km_outlines *o, double x, double y, double radius) {
  o->low[0] = fmin(o->low[0], x - radius);
  o->low[1] = fmin(o->low[1], y - radius);
  o->high[0] = fmax(o->high[0], x + radius);
  o->high[1] = fmax(o->high[1], y + radius);
}

static void add(work *w, km_outline_part part) {
  void *parts = w->out->parts;
  if (!km_arena_grow(&w->studio.arena, &parts, &w->capacity, w->out->count + 1, sizeof part))
    return;
  w->out->parts = parts;
  part.colour = w->studio.shapes[part.body].colour;
  w->out->parts[w->out->count++] = part;
  reach(w->out, part.from.x, part.from.y, part.radius);
}

/* Position of a body's point in the plane: x to the right, y upwards, from the inertial origin. */
static km_spot flat(const work *w, int body, km_vec3 point) {
  const km_drawing_def *d = w->studio.drawing;
  km_vec3 p = km_pose_point(&d->poses[d->full * (size_t)d->mechanism->model->body_count + (size_t)body], point);
  return (km_spot){km_vec3_dot(w->studio.view.right, p), km_vec3_dot(w->studio.view.up, p), 0};
}

/* Offset curve of a convex hull, counterclockwise: a line parallel to each edge, an arc about each corner. */
static void add_around(work *w, int body, const km_spot *hull, int count) {
  double r = 0.5 * w->out->width;
  for (int i = 0; i < count; ++i) {
    km_spot a = hull[i], b = hull[(i + 1) % count], c = hull[(i + 2) % count];
    double turn = atan2(a.x - b.x, b.y - a.y), next = atan2(b.x - c.x, c.y - b.y); /* angles of the outward normals */
    double x = r * cos(turn), y = r * sin(turn);
    add(w, (km_outline_part){KM_OUTLINE_LINE, body, -1, {a.x + x, a.y + y}, {b.x + x, b.y + y}, 0, 0, 0});
    add(w, (km_outline_part){KM_OUTLINE_ARC, body, -1, {b.x, b.y}, {0, 0}, r, turn, next});
  }
}

static void add_outline(work *w, int body) {
  const km_shape *shape = &w->studio.shapes[body];
  km_spot *spots = KM_ARENA_NEW(&w->studio.arena, km_spot, (size_t)shape->count);
  km_spot *hull = KM_ARENA_NEW(&w->studio.arena, km_spot, 2 * (size_t)shape->count + 1);
  if (!spots || !hull || shape->count == 0)
    return;
  for (int i = 0; i < shape->count; ++i)
    spots[i] = flat(w, body, shape->points[i]);
  int corners = shape->count > 1 ? km_convex_hull(spots, shape->count, hull) : 1;
  if (corners > 1)
    add_around(w, body, hull, corners);
  else
    add(w, (km_outline_part){KM_OUTLINE_CIRCLE, body, -1, {spots[0].x, spots[0].y}, {0, 0}, 0.5 * w->out->width, 0, 0});
}

/* A hole for each hinge, once for those in one place. */
static void add_holes(work *w, int body) {
  const km_model *model = w->studio.drawing->mechanism->model;
  size_t first = w->out->count;
  double r = hole * w->out->width;
  for (int j = 0; j < model->joint_count; ++j)
    for (int end = 0; end < 2; ++end) {
      if (km_joint_body(model, j, end) != body || w->studio.marks[j].look != KM_LOOK_PIN)
        continue;
      km_spot at = flat(w, body, model->frames[model->joints[j].frame[end]].pose.p);
      bool known = false;
      for (size_t i = first; i < w->out->count; ++i)
        known = known || hypot(w->out->parts[i].from.x - at.x, w->out->parts[i].from.y - at.y) < 0.01 * r;
      if (!known)
        add(w, (km_outline_part){KM_OUTLINE_CIRCLE, body, -1, {at.x, at.y}, {0, 0}, r, 0, 0});
    }
}

/* Two digits of a length. */
static double rounded(double length) {
  double step = pow(10.0, floor(log10(length)) - 1.0);
  return round(length / step) * step;
}

static void find(work *w, double width) {
  const double as_drawn = 1.7; /* radii of a pin */
  const km_model *model = w->studio.drawing->mechanism->model;
  w->out->width = width > 0.0 ? width : rounded(as_drawn * w->studio.radius / w->studio.view.scale);
  for (int b = 0; b < model->body_count; ++b) {
    if (b > 0)
      add_outline(w, b);
    add_holes(w, b);
  }
}

km_status km_outlines_make(const km_drawing_def *drawing, double width, km_arena *arena, km_outlines *out,
                           km_error *error) {
  *out = (km_outlines){.model = drawing->mechanism->model, .low = {HUGE_VAL, HUGE_VAL}, .high = {-HUGE_VAL, -HUGE_VAL}};
  if (!km_drawing_def_is_planar(drawing))
    return km_fail(error, KM_USAGE,
                   "outlines of links that don't move in the plane of the view; expected a mechanism "
                   "in a plane, seen along its axes");
  work w = {.studio = {.drawing = drawing, .place = {0, 0, 504, 324}}, .out = out};
  if (km_studio_open(&w.studio))
    find(&w, width);
  km_outline_part *parts = KM_ARENA_NEW(arena, km_outline_part, out->count + 1);
  for (size_t i = 0; parts && i < out->count; ++i)
    parts[i] = out->parts[i];
  out->parts = parts;
  km_status status = km_studio_close(&w.studio, error);
  return status == KM_OK && arena->failed ? km_fail(error, KM_MEMORY, "out of memory for outlines") : status;
}

typedef struct sheet {
  const km_outlines *outlines;
  km_canvas *canvas;
  double scale, margin; /* points per model's unit; points */
} sheet;

static km_canvas_point on_page(const sheet *s, double x, double y) {
  return (km_canvas_point){s->margin + s->scale * (x - s->outlines->low[0]),
                           s->margin + s->scale * (s->outlines->high[1] - y)};
}

enum { SEGMENTS = 96 }; /* corners of a full circle's polygon: an outline of 10 mm is 0.003 mm off */

static void draw_part(const sheet *s, const km_outline_part *p) {
  const km_pen pen = {.colour = km_palette_text(p->colour), .width = 0.5};
  if (p->kind == KM_OUTLINE_LINE) {
    km_canvas_line(s->canvas, &pen, on_page(s, p->from.x, p->from.y), on_page(s, p->to.x, p->to.y));
    return;
  }
  if (p->kind == KM_OUTLINE_CIRCLE) {
    km_canvas_circle(s->canvas, (km_colour){1, 1, 1, 0}, &pen, on_page(s, p->from.x, p->from.y), s->scale * p->radius);
    return;
  }
  km_canvas_point points[SEGMENTS + 1];
  double turn = fmod(p->end - p->begin + 4.0 * M_PI, 2.0 * M_PI);
  int count = (int)ceil(turn / (2.0 * M_PI) * SEGMENTS) + 1;
  for (int i = 0; i < count; ++i) {
    double angle = p->begin + turn * i / (count > 1 ? count - 1 : 1);
    points[i] = on_page(s, p->from.x + p->radius * cos(angle), p->from.y + p->radius * sin(angle));
  }
  km_canvas_polyline(s->canvas, &pen, points, (size_t)count);
}

km_status km_outlines_render(const km_outlines *o, double scale, km_picture_format format, km_text *out,
                             km_error *error) {
  const double inch = 0.0254;
  sheet s = {.outlines = o, .scale = scale * o->model->units.length->si / inch * 72.0, .margin = 18};
  bool any = o->count > 0;
  double width = any ? s.scale * (o->high[0] - o->low[0]) : 0.0,
         height = any ? s.scale * (o->high[1] - o->low[1]) : 0.0;
  km_status status = km_canvas_create(format, width + 2 * s.margin, height + 2 * s.margin, out, &s.canvas, error);
  if (status)
    return status;
  for (size_t i = 0; i < o->count; ++i)
    draw_part(&s, &o->parts[i]);
  status = km_canvas_finish(s.canvas, error);
  km_canvas_free(s.canvas);
  return status;
}
