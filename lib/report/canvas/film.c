/* Films in the making: recorded shapes, their styles on light and dark paper. */
#include "report/canvas/film.h"

#include "base/text.h"

#include <math.h>
#include <string.h>

enum { FINE = 2, COARSE = 1 }; /* decimals of what is written once, and of what is written frame by frame */

static const double coarse_slack = 0.06; /* points: half of what the grid hides */

static double luminance(km_colour c) {
  return 0.2126 * c.red + 0.7152 * c.green + 0.0722 * c.blue;
}

/* Greys change places, so that ink is light on dark paper; colours too dark to be seen there become lighter. */
static km_colour on_dark(km_colour c) {
  const double grey = 0.03, dark = 0.45, lighter = 0.35;
  double least = fmin(c.red, fmin(c.green, c.blue)), most = fmax(c.red, fmax(c.green, c.blue));
  double part = most - least < grey ? 0.0 : luminance(c) < dark ? lighter : 0.0;
  if (most - least < grey)
    return (km_colour){0.93 - 0.83 * c.red, 0.93 - 0.83 * c.green, 0.93 - 0.82 * c.blue, c.alpha};
  return (km_colour){c.red + part * (1 - c.red), c.green + part * (1 - c.green), c.blue + part * (1 - c.blue), c.alpha};
}

static void add_colour(km_text *out, const char *property, km_colour c) {
  km_text_format(out, "%s:#%02x%02x%02x;", property, (unsigned)lround(255 * c.red), (unsigned)lround(255 * c.green),
                 (unsigned)lround(255 * c.blue));
  if (c.alpha < 1.0) {
    km_text_format(out, "%s-opacity:", property);
    km_text_number(out, round(100 * c.alpha) / 100);
    km_text_add(out, ";");
  }
}

static void add_width(km_text *out, const char *property, double width) {
  km_text_format(out, "%s:", property);
  km_text_number(out, round(100 * width) / 100);
}

static const char *shape_style(km_film *film, const km_colour *fill, const km_pen *pen, bool dark) {
  km_text text = {0};
  km_text_add(&text, "");
  if (fill)
    add_colour(&text, "fill", dark ? on_dark(*fill) : *fill);
  if (pen) {
    add_colour(&text, "stroke", dark ? on_dark(pen->colour) : pen->colour);
    add_width(&text, "stroke-width", pen->width);
    for (size_t i = 0; i < pen->dash_count && pen->dash; ++i)
      add_width(&text, i ? " " : ";stroke-linecap:butt;stroke-dasharray", pen->dash[i] * pen->width);
  }
  const char *style = text.failed ? NULL : km_arena_string(film->arena, text.data);
  film->arena->failed = film->arena->failed || text.failed;
  km_text_free(&text);
  return style;
}

static const char *text_style(km_film *film, const km_font *font, km_colour colour, bool dark) {
  km_text text = {0};
  add_colour(&text, "fill", dark ? on_dark(colour) : colour);
  add_width(&text, "font-size", font->size);
  km_text_add(&text, font->bold ? "px;font-weight:bold" : "px");
  const char *style = text.failed ? NULL : km_arena_string(film->arena, text.data);
  film->arena->failed = film->arena->failed || text.failed;
  km_text_free(&text);
  return style;
}

static bool grow(km_film *film, void **items, size_t *capacity, size_t count, size_t size) {
  return !film->arena->failed && km_arena_grow(film->arena, items, capacity, count + 1, size);
}

static int style_index(km_film *film, const char *light, const char *dark) {
  if (film->arena->failed)
    return 0;
  for (size_t i = 0; i < film->style_count; ++i)
    if (strcmp(film->styles[i].light, light) == 0)
      return (int)i;
  void *styles = film->styles;
  if (!grow(film, &styles, &film->style_capacity, film->style_count, sizeof *film->styles))
    return 0;
  film->styles = styles;
  film->styles[film->style_count] = (km_film_style){light, dark};
  return (int)film->style_count++;
}

static void add_shape(km_film *film, km_film_shape shape) {
  void *items = film->into->items;
  if (!shape.path || !grow(film, &items, &film->into->capacity, film->into->count, sizeof shape)) {
    film->arena->failed = true;
    return;
  }
  film->into->items = items;
  film->into->items[film->into->count++] = shape;
}

static void record_shape(void *context, const char *path, const km_colour *fill, const km_pen *pen) {
  km_film *film = context;
  if (!film->into)
    return;
  int style = style_index(film, shape_style(film, fill, pen, false), shape_style(film, fill, pen, true));
  add_shape(film, (km_film_shape){.style = style, .path = km_arena_string(film->arena, path)});
}

static void record_line(void *context, const char *text, const km_font *font, km_colour colour, km_canvas_point at,
                        double width, double angle) {
  km_film *film = context;
  if (!film->into)
    return;
  int style = style_index(film, text_style(film, font, colour, false), text_style(film, font, colour, true));
  add_shape(film, (km_film_shape){style, km_arena_string(film->arena, text), true, at.x, at.y, width, angle});
}

km_status km_film_open(km_film *film, km_arena *arena, double width, double height, size_t frame_count,
                       km_error *error) {
  *film = (km_film){.arena = arena, .width = width, .height = height, .frame_count = frame_count};
  film->recorder = (km_canvas_recorder){record_shape, record_line, film, FINE, 0.0};
  return km_canvas_record(&film->recorder, &film->canvas, error);
}

km_status km_film_end(km_film *film, km_error *error) {
  km_status status = km_canvas_finish(film->canvas, error);
  return status == KM_OK && film->arena->failed ? km_fail(error, KM_MEMORY, "out of memory for a film") : status;
}

void km_film_close(km_film *film) {
  km_canvas_free(film->canvas);
  film->canvas = NULL;
}

km_film_mover *km_film_add_mover(km_film *film, bool turns) {
  void *movers = film->movers;
  if (!grow(film, &movers, &film->mover_capacity, film->mover_count, sizeof *film->movers))
    return NULL;
  film->movers = movers;
  km_film_mover *mover = &film->movers[film->mover_count];
  mover->x = KM_ARENA_NEW(film->arena, double, film->frame_count);
  mover->y = KM_ARENA_NEW(film->arena, double, film->frame_count);
  mover->angle = turns ? KM_ARENA_NEW(film->arena, double, film->frame_count) : NULL;
  if (film->arena->failed)
    return NULL;
  film->mover_count++;
  return mover;
}

km_film_group *km_film_begin(km_film *film, int mover) {
  void *groups = film->groups;
  size_t lists = mover == KM_FILM_DRAWN ? film->frame_count : 1;
  film->into = NULL;
  if (!grow(film, &groups, &film->group_capacity, film->group_count, sizeof *film->groups))
    return NULL;
  film->groups = groups;
  km_film_group *group = &film->groups[film->group_count];
  *group = (km_film_group){.mover = mover, .shapes = KM_ARENA_NEW(film->arena, km_film_shapes, lists)};
  if (!group->shapes)
    return NULL;
  film->group_count++;
  film->into = group->shapes;
  film->recorder.decimals = mover == KM_FILM_DRAWN ? COARSE : FINE;
  film->recorder.slack = mover == KM_FILM_DRAWN ? coarse_slack : 0.0;
  return group;
}

void km_film_frame(km_film *film, size_t frame) {
  film->into = film->arena->failed ? NULL : &film->groups[film->group_count - 1].shapes[frame];
}
