/* Painting links: every one a dark rim, a fill in the body's colour and a lighter streak. */
#include "report/canvas/palette.h"
#include "report/drawing/drawing_parts.h"

static const km_colour white = {1, 1, 1, 1}, dark = {0.15, 0.15, 0.15, 1};

km_colour km_mix(km_colour a, km_colour b, double part) {
  return (km_colour){a.red + part * (b.red - a.red), a.green + part * (b.green - a.green),
                     a.blue + part * (b.blue - a.blue), a.alpha};
}

km_colour km_faded(const km_scene *scene, km_colour colour) {
  return km_mix(colour, white, scene->fade);
}

static km_pen pen_of(km_colour colour, double width) {
  return (km_pen){.colour = colour, .width = width};
}

typedef struct tint {
  km_colour rim, fill, streak;
} tint;

static tint tint_of(const km_scene *scene, int body) {
  km_colour colour = km_palette_colour(scene->shapes[body].colour);
  return (tint){km_faded(scene, km_mix(colour, dark, 0.55)), km_faded(scene, km_mix(colour, white, 0.38)),
                km_faded(scene, km_mix(colour, white, 0.72))};
}

/* White along both sides of a link sets it off from those behind it, but not at its ends, where it
 * meets its neighbours. */
static void paint_seam(const km_scene *scene, km_canvas *canvas, const km_item *item) {
  const km_spot *a = &item->spots[0], *b = &item->spots[1];
  double length = km_spot_distance(*a, *b), end = 2.6 * scene->radius;
  km_pen seam = pen_of(white, 2.0 * item->reach + 1.1 * scene->radius);
  if (!scene->halo || length <= 2.0 * end + seam.width)
    return;
  double x = (b->x - a->x) / length * end, y = (b->y - a->y) / length * end;
  km_canvas_line(canvas, &seam, (km_canvas_point){a->x + x, a->y + y}, (km_canvas_point){b->x - x, b->y - y});
}

/* A rounded bar along a line, lit from above. */
static void paint_bar(const km_scene *scene, km_canvas *canvas, const km_item *item, tint t) {
  double width = 2.0 * item->reach, rim = 0.16 * scene->radius;
  km_canvas_point a = {item->spots[0].x, item->spots[0].y}, b = {item->spots[1].x, item->spots[1].y};
  paint_seam(scene, canvas, item);
  km_pen outline = pen_of(t.rim, width + 2.0 * rim), fill = pen_of(t.fill, width),
         streak = pen_of(t.streak, 0.3 * width);
  km_canvas_line(canvas, &outline, a, b);
  km_canvas_line(canvas, &fill, a, b);
  double length = hypot(b.x - a.x, b.y - a.y), shift = 0.2 * width;
  if (length <= 0.0)
    return;
  double x = (b.y - a.y) / length * shift, y = -(b.x - a.x) / length * shift;
  if (y > 0.0) {
    x = -x;
    y = -y;
  }
  km_canvas_line(canvas, &streak, (km_canvas_point){a.x + x, a.y + y}, (km_canvas_point){b.x + x, b.y + y});
}

static km_canvas_point *corners(const km_scene *scene, const km_item *item) {
  km_canvas_point *points = KM_ARENA_NEW(scene->arena, km_canvas_point, (size_t)item->count + 2);
  for (int i = 0; points && i < item->count + 2; ++i) {
    const km_spot *spot = &item->spots[i % item->count];
    points[i] = (km_canvas_point){spot->x, spot->y};
  }
  return points;
}

/* A plate with round corners: its outline is drawn by a thick pen, so that it ends as bars do. */
static void paint_plate(const km_scene *scene, km_canvas *canvas, const km_item *item, tint t) {
  double width = 2.0 * item->reach, rim = 0.16 * scene->radius;
  size_t count = (size_t)item->count;
  km_canvas_point *points = corners(scene, item);
  if (!points)
    return;
  km_pen outline = pen_of(t.rim, width + 2.0 * rim), edge = pen_of(t.fill, width);
  km_colour inside = km_mix(t.fill, t.streak, 0.55), veil = inside;
  veil.alpha = 0.72;
  km_canvas_polyline(canvas, &outline, points, count + 2);
  km_canvas_polygon(canvas, scene->fade > 0.0 ? inside : veil, points, count);
  km_canvas_polyline(canvas, &edge, points, count + 2);
}

/* A cylinder with square ends, in which a rod slides. */
static void paint_barrel(const km_scene *scene, km_canvas *canvas, const km_item *item, tint t) {
  const km_spot *a = &item->spots[0], *b = &item->spots[1];
  double length = km_spot_distance(*a, *b), rim = 0.32 * scene->radius;
  if (length <= 0.0)
    return;
  double x = (b->x - a->x) / length, y = (b->y - a->y) / length, r = item->reach;
  const km_canvas_point box[] = {{a->x - r * y, a->y + r * x}, {b->x - r * y, b->y + r * x},
                                 {b->x + r * y, b->y - r * x}, {a->x + r * y, a->y - r * x},
                                 {a->x - r * y, a->y + r * x}, {b->x - r * y, b->y + r * x}};
  km_pen outline = pen_of(t.rim, rim), streak = pen_of(t.streak, 0.6 * r);
  paint_seam(scene, canvas, item);
  km_canvas_polygon(canvas, t.fill, box, 4);
  double side = x > 0.0 || (x == 0.0 && y > 0.0) ? 0.35 * r : -0.35 * r; /* the upper side */
  km_canvas_line(canvas, &streak, (km_canvas_point){a->x + side * y + r * x, a->y - side * x + r * y},
                 (km_canvas_point){b->x + side * y - r * x, b->y - side * x - r * y});
  km_canvas_polyline(canvas, &outline, box, 6);
}

static void paint_base(const km_scene *scene, km_canvas *canvas, const km_item *item) {
  static const double dashes[] = {3, 2};
  const km_colour grey = km_faded(scene, (km_colour){0.55, 0.55, 0.55, 1});
  km_canvas_point *points = corners(scene, item);
  if (!points)
    return;
  km_pen edge = {.colour = grey, .width = 0.3 * scene->radius, .dash = dashes, .dash_count = 2};
  km_canvas_polygon(canvas, km_faded(scene, (km_colour){0.93, 0.93, 0.93, 1}), points, (size_t)item->count);
  km_canvas_polyline(canvas, &edge, points, (size_t)item->count + (item->count > 2));
}

void km_item_paint(const km_scene *scene, km_canvas *canvas, const km_item *item) {
  switch (item->kind) {
  case KM_ITEM_BASE:
    paint_base(scene, canvas, item);
    return;
  case KM_ITEM_MOUNT:
  case KM_ITEM_RAIL:
    km_ground_paint(scene, canvas, item);
    return;
  case KM_ITEM_PLATE:
    paint_plate(scene, canvas, item, tint_of(scene, item->body));
    return;
  case KM_ITEM_BAR:
  case KM_ITEM_ROD:
    paint_bar(scene, canvas, item, tint_of(scene, item->body));
    return;
  case KM_ITEM_BARREL:
    paint_barrel(scene, canvas, item, tint_of(scene, item->body));
    return;
  case KM_ITEM_SYMBOL:
    km_symbol_paint(scene, canvas, item);
    return;
  }
}

void km_scene_paint_base(const km_scene *scene, km_canvas *canvas) {
  for (size_t i = 0; i < scene->count; ++i)
    if (scene->items[i].kind == KM_ITEM_BASE)
      km_item_paint(scene, canvas, &scene->items[i]);
}

void km_scene_paint(const km_scene *scene, km_canvas *canvas) {
  for (const km_face *face = scene->faces; face; face = face->next)
    km_face_paint(scene, canvas, face);
  for (size_t i = 0; i < scene->count; ++i)
    if (scene->items[i].kind != KM_ITEM_BASE)
      km_item_paint(scene, canvas, &scene->items[i]);
}
