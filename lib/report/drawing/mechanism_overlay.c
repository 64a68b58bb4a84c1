/* Mechanisms that are compared, over each other: links as lines, each mechanism in a colour of its own. */
#include "report/canvas/palette.h"
#include "report/drawing/drawing_parts.h"

static const double pin = 3.2; /* points on a page of the default size */

/* Extent of all drawings, about the origin of the first. */
static km_extent common_extent(const km_studio *studios, int count) {
  const km_projection *view = &studios[0].view;
  km_extent all = studios[0].extent;
  for (int k = 1; k < count; ++k) {
    km_extent own = km_extent_of(studios[k].drawing, studios[k].shapes, view);
    km_vec3 way = km_vec3_sub(own.origin, all.origin);
    const double shift[2] = {km_vec3_dot(way, view->right), km_vec3_dot(way, view->up)};
    for (int i = 0; i < 2; ++i) {
      all.low[i] = fmin(all.low[i], own.low[i] + shift[i]);
      all.high[i] = fmax(all.high[i], own.high[i] + shift[i]);
    }
  }
  return all;
}

static void share_view(km_studio *studios, int count) {
  km_extent all = common_extent(studios, count);
  km_projection_fit(&studios[0].view, &all, km_studio_inner(&studios[0]));
  for (int k = 0; k < count; ++k) {
    studios[k].view = studios[0].view;
    studios[k].radius = pin * studios[0].size; /* constant size, whatever the distance of the joints */
  }
}

static void paint_line(const km_scene *scene, km_canvas *canvas, const km_item *item, km_colour colour) {
  const km_pen pen = {.colour = colour, .width = 0.5 * scene->radius};
  km_canvas_point *points = KM_ARENA_NEW(scene->arena, km_canvas_point, (size_t)item->count + 1);
  size_t count = (size_t)item->count + (item->count > 2); /* a plate is closed */
  for (size_t i = 0; points && i < count; ++i) {
    const km_spot *spot = &item->spots[i % (size_t)item->count];
    points[i] = (km_canvas_point){spot->x, spot->y};
  }
  if (!points)
    return;
  if (item->count > 2) {
    colour.alpha = 0.12;
    km_canvas_polygon(canvas, colour, points, (size_t)item->count);
  }
  km_canvas_polyline(canvas, &pen, points, count);
}

static void paint_pin(const km_scene *scene, km_canvas *canvas, const km_item *item, km_colour colour) {
  const km_pen rim = {.colour = colour, .width = 0.3 * scene->radius};
  km_canvas_circle(canvas, (km_colour){1, 1, 1, 1}, &rim, (km_canvas_point){item->spots[0].x, item->spots[0].y},
                   0.5 * scene->radius);
}

static void paint_ground(const km_scene *scene, km_canvas *canvas) {
  for (size_t i = 0; i < scene->count; ++i)
    if (scene->items[i].kind == KM_ITEM_MOUNT || scene->items[i].kind == KM_ITEM_RAIL)
      km_item_paint(scene, canvas, &scene->items[i]);
}

static void paint_links(const km_scene *scene, km_canvas *canvas, km_colour colour) {
  for (int pass = 0; pass < 2; ++pass) /* pins lie over all links */
    for (size_t i = 0; i < scene->count; ++i) {
      const km_item *item = &scene->items[i];
      bool link = item->kind == KM_ITEM_PLATE || item->kind == KM_ITEM_BAR || item->kind == KM_ITEM_ROD ||
                  item->kind == KM_ITEM_BARREL;
      if (pass == 0 && link)
        paint_line(scene, canvas, item, colour);
      else if (pass == 1 && item->kind == KM_ITEM_SYMBOL)
        paint_pin(scene, canvas, item, colour);
    }
}

static void paint(km_studio *studios, const int *colours, int count, km_arena *arena) {
  km_scene *scenes = KM_ARENA_NEW(arena, km_scene, (size_t)count);
  for (int k = 0; k < count && scenes && !arena->failed; ++k) {
    scenes[k] = km_studio_scene(&studios[k], studios[k].drawing->full, 0.0);
    scenes[k].arena = arena;
    km_scene_build(&scenes[k]);
  }
  if (!arena->failed) {
    scenes[0].fade = 0.4; /* the ground steps back */
    paint_ground(&scenes[0], studios[0].canvas);
  }
  for (int k = 0; k < count && !arena->failed; ++k)
    paint_links(&scenes[k], studios[k].canvas, km_palette_text(colours[k]));
}

km_status km_drawing_overlay(const km_drawing_def *drawings, const int *colours, int count, km_canvas *canvas,
                             km_rectangle place, km_error *error) {
  km_arena arena = {0};
  km_studio *studios = KM_ARENA_NEW(&arena, km_studio, (size_t)count);
  int opened = 0;
  bool ready = studios && count > 0;
  for (; ready && opened < count; ++opened) {
    studios[opened] = (km_studio){.drawing = &drawings[opened], .canvas = canvas, .place = place};
    ready = km_studio_open(&studios[opened]);
  }
  if (ready) {
    share_view(studios, count);
    paint(studios, colours, count, &arena);
  }
  km_status status = arena.failed ? km_fail(error, KM_MEMORY, "out of memory for a drawing") : KM_OK;
  for (int k = 0; k < opened; ++k) {
    km_status closed = km_studio_close(&studios[k], error);
    status = status ? status : closed;
  }
  km_arena_free(&arena);
  return status;
}
