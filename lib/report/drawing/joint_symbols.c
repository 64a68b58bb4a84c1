/* The symbols of textbooks for joints and the ground. Sizes are in radii of a pin. */
#include "report/drawing/drawing_parts.h"

static const km_colour paper = {1, 1, 1, 1}, ink = {0.13, 0.13, 0.13, 1}, stone = {0.86, 0.86, 0.86, 1};
static const double end_on = 0.97; /* cosine: an axis that steep is seen from its end */

typedef struct brush {
  const km_scene *scene;
  km_canvas *canvas;
  km_spot at;
  double r;
  km_pen pen;
  km_colour fill, side; /* lightness of faces towards the viewer, and of others */
} brush;

static brush brush_of(const km_scene *scene, km_canvas *canvas, const km_item *item) {
  km_pen pen = {.colour = km_faded(scene, ink), .width = 0.34 * scene->radius};
  return (brush){scene, canvas, item->spots[0], scene->radius, pen, paper, km_faded(scene, stone)};
}

/* A point of the symbol: `along` and `across` a direction on the page. */
static km_canvas_point spot(const brush *b, km_spot direction, double along, double across) {
  return (km_canvas_point){b->at.x + b->r * (along * direction.x - across * direction.y),
                           b->at.y + b->r * (along * direction.y + across * direction.x)};
}

/* The direction of an axis on the page, of length 1; across the page where it has none. */
static km_spot flat(km_spot axis) {
  double length = hypot(axis.x, axis.y);
  return length > 1e-9 ? (km_spot){axis.x / length, axis.y / length, axis.depth} : (km_spot){1, 0, axis.depth};
}

static void disc(const brush *b, km_colour fill, double radius) {
  km_canvas_circle(b->canvas, fill, &b->pen, (km_canvas_point){b->at.x, b->at.y}, radius * b->r);
}

static void line(const brush *b, km_canvas_point from, km_canvas_point to) {
  km_canvas_line(b->canvas, &b->pen, from, to);
}

enum { ARC = 25 };

/* Part of an ellipse about (along, 0): half axes `flatness` along the direction, `radius` across.
 */
static void arc(const brush *b, km_spot direction, double along, double flatness, double radius, double from, double to,
                km_canvas_point out[ARC]) {
  for (int i = 0; i < ARC; ++i) {
    double angle = from + (to - from) * i / (ARC - 1);
    out[i] = spot(b, direction, along + flatness * cos(angle), radius * sin(angle));
  }
}

static void outline(const brush *b, km_colour fill, const km_canvas_point *points, size_t count) {
  km_canvas_polygon(b->canvas, fill, points, count);
  km_canvas_polyline(b->canvas, &b->pen, points, count);
  line(b, points[count - 1], points[0]);
}

/* A cylinder about an axis, with the end that faces the viewer. */
static void cylinder(const brush *b, km_spot axis, double half, double radius) {
  km_spot d = flat(axis);
  double lean = fabs(axis.depth), length = half * sqrt(fmax(0.0, 1.0 - lean * lean));
  if (axis.depth < 0.0)
    d = (km_spot){-d.x, -d.y, -d.depth};
  km_canvas_point side[2 * ARC], cap[ARC];
  arc(b, d, length, lean * radius, radius, -0.5 * M_PI, 0.5 * M_PI, side);
  arc(b, d, -length, lean * radius, radius, 0.5 * M_PI, 1.5 * M_PI, side + ARC);
  outline(b, b->side, side, 2 * ARC);
  arc(b, d, length, lean * radius, radius, 0.0, 2.0 * M_PI, cap);
  outline(b, b->fill, cap, ARC);
}

static void pin(const brush *b, km_spot axis) {
  if (fabs(axis.depth) > end_on)
    disc(b, b->fill, 1.0);
  else
    cylinder(b, axis, 1.6, 0.95);
}

static void box(const brush *b, km_spot d, double along, double across) {
  const km_canvas_point points[] = {spot(b, d, -along, -across), spot(b, d, along, -across), spot(b, d, along, across),
                                    spot(b, d, -along, across)};
  outline(b, b->fill, points, 4);
}

/* A block on its guide; along the guide it is a square with the guide's end. */
static void slider(const brush *b, km_spot axis) {
  if (fabs(axis.depth) > end_on) {
    box(b, (km_spot){1, 0, 0}, 1.4, 1.4);
    disc(b, b->pen.colour, 0.3);
    return;
  }
  box(b, flat(axis), 0.9 + 1.1 * hypot(axis.x, axis.y), 1.35);
}

/* A ball in its socket. */
static void ball(const brush *b) {
  km_canvas_point socket[ARC];
  km_pen pen = b->pen;
  pen.width *= 1.5;
  arc(b, (km_spot){0, 1, 0}, 0.0, 1.65, 1.65, -1.9, 1.9, socket);
  disc(b, b->fill, 1.1);
  km_canvas_polyline(b->canvas, &pen, socket, ARC);
}

static void cross(const brush *b, const km_spot axis[2]) {
  int shown = hypot(axis[1].x, axis[1].y) > hypot(axis[0].x, axis[0].y);
  km_spot d = flat(axis[shown]), other = flat(axis[!shown]);
  if (hypot(axis[!shown].x, axis[!shown].y) < 0.25 || fabs(d.x * other.y - d.y * other.x) < 0.6)
    other = (km_spot){-d.y, d.x, 0}; /* axes on one line of the page still make a cross */
  disc(b, b->fill, 1.5);
  line(b, spot(b, d, -1.5, 0), spot(b, d, 1.5, 0));
  line(b, spot(b, other, -1.5, 0), spot(b, other, 1.5, 0));
}

/* A rod through a sleeve that it turns in, too. */
static void sleeve(const brush *b, km_spot axis) {
  km_spot d = flat(axis);
  double length = hypot(axis.x, axis.y);
  line(b, spot(b, d, -4.0 * length, 0), spot(b, d, 4.0 * length, 0));
  cylinder(b, axis, 2.1, 1.2);
}

static void screw(const brush *b, km_spot axis) {
  if (fabs(axis.depth) > end_on) {
    disc(b, b->fill, 1.4);
    disc(b, b->fill, 0.7);
    return;
  }
  km_spot d = flat(axis);
  line(b, spot(b, d, -3.6, 0), spot(b, d, 3.6, 0));
  box(b, d, 2.2, 1.2);
  for (int i = 0; i < 4; ++i)
    line(b, spot(b, d, -2.2 + 1.1 * i, 1.2), spot(b, d, -1.1 + 1.1 * i, -1.2));
}

/* A tile on the plane in which the joint slides and turns. */
static void tile(const brush *b, const km_spot axis[2]) {
  km_canvas_point points[4];
  for (int i = 0; i < 4; ++i) {
    double u = i == 0 || i == 3 ? -2.2 : 2.2, v = i < 2 ? -2.2 : 2.2;
    points[i] = (km_canvas_point){b->at.x + b->r * (u * axis[0].x + v * axis[1].x),
                                  b->at.y + b->r * (u * axis[0].y + v * axis[1].y)};
  }
  outline(b, b->side, points, 4);
  disc(b, b->fill, 0.7);
}

static void loose(const brush *b) {
  static const double dashes[] = {2, 1.6};
  km_pen pen = b->pen;
  km_canvas_point ring[ARC];
  pen.dash = dashes;
  pen.dash_count = 2;
  arc(b, (km_spot){1, 0, 0}, 0.0, 1.5, 1.5, 0.0, 2.0 * M_PI, ring);
  km_canvas_polyline(b->canvas, &pen, ring, ARC);
  disc(b, b->pen.colour, 0.3);
}

double km_symbol_reach(const km_scene *scene, int joint) {
  static const double reaches[] = {
      [KM_LOOK_PIN] = 1.3,   [KM_LOOK_ACTUATOR] = 1.5, [KM_LOOK_SLIDER] = 2.0, [KM_LOOK_WELD] = 1.2,
      [KM_LOOK_BALL] = 1.9,  [KM_LOOK_FREE] = 1.7,     [KM_LOOK_SLEEVE] = 2.3, [KM_LOOK_CROSS] = 1.8,
      [KM_LOOK_TABLE] = 2.5, [KM_LOOK_SCREW] = 2.5};
  km_look look = scene->marks[joint].look;
  if (look == KM_LOOK_ACTUATOR && km_joint_is_solid(scene, joint))
    look = KM_LOOK_SLIDER;
  return scene->radius * (look == KM_LOOK_PIN && !scene->view->planar ? 1.9 : reaches[look]);
}

/* A joint that is held is as good as welded, and filled as a weld is. */
static bool is_held(const km_scene *scene, int joint) {
  const km_mechanism *m = scene->mechanism;
  return km_model_freedom(m->model, joint) > 0 && m->held[m->model->joints[joint].first_coordinate];
}

void km_symbol_paint(const km_scene *scene, km_canvas *canvas, const km_item *item) {
  brush b = brush_of(scene, canvas, item);
  if (is_held(scene, item->joint))
    b.fill = b.side = km_mix(b.pen.colour, paper, 0.25);
  switch (scene->marks[item->joint].look) {
  case KM_LOOK_PIN:
    pin(&b, item->axis[0]);
    return;
  case KM_LOOK_ACTUATOR:
  case KM_LOOK_SLIDER:
    slider(&b, item->axis[0]);
    return;
  case KM_LOOK_WELD:
    disc(&b, b.pen.colour, 0.75);
    return;
  case KM_LOOK_BALL:
    ball(&b);
    return;
  case KM_LOOK_FREE:
    loose(&b);
    return;
  case KM_LOOK_SLEEVE:
    sleeve(&b, item->axis[0]);
    return;
  case KM_LOOK_CROSS:
    cross(&b, item->axis);
    return;
  case KM_LOOK_TABLE:
    tile(&b, item->axis);
    return;
  case KM_LOOK_SCREW:
    screw(&b, item->axis[0]);
    return;
  }
}

/* Ground: a line with strokes behind it, from -half to half along `d`, `away` from the joint. */
static void hatching(const brush *b, km_spot d, double half, double away) {
  int strokes = (int)fmin(fmax(half / 0.4, 4.0), 400.0);
  double gap = 2.0 * half / strokes;
  brush thin = *b;
  thin.pen.width *= 0.7;
  for (int i = 0; i < strokes; ++i) {
    double from = -half + gap * (i + 0.85);
    line(&thin, spot(b, d, from, away), spot(b, d, from - 0.9, away + 1.1));
  }
  line(b, spot(b, d, -half, away), spot(b, d, half, away));
}

static void mount(const brush *b, km_spot down) {
  const km_spot d = {down.y, -down.x, 0}; /* direction along the ground; `across` points away from the joint */
  const km_canvas_point feet[] = {spot(b, d, 0, 0), spot(b, d, -1.7, 3.0), spot(b, d, 1.7, 3.0)};
  outline(b, b->side, feet, 3);
  hatching(b, d, 2.8, 3.0);
}

/* Beneath it, or else to the right. */
km_spot km_rail_side(const km_item *rail) {
  km_spot d = flat(rail->axis[0]);
  bool upright = fabs(d.x) < 1e-6;
  double sign = (upright ? -d.y : d.x) < 0.0 ? -1.0 : 1.0;
  return (km_spot){-sign * d.y, sign * d.x, 0};
}

void km_ground_paint(const km_scene *scene, km_canvas *canvas, const km_item *item) {
  brush b = brush_of(scene, canvas, item);
  if (item->kind == KM_ITEM_MOUNT) {
    mount(&b, item->axis[0]);
    return;
  }
  km_spot side = km_rail_side(item), d = {side.y, -side.x, 0};
  b.at.x = 0.5 * (item->spots[0].x + item->spots[1].x);
  b.at.y = 0.5 * (item->spots[0].y + item->spots[1].y);
  double half = 0.5 * km_spot_distance(item->spots[0], item->spots[1]) / b.r;
  hatching(&b, d, fmax(half, 2.5), 1.5);
}
