/* Turns the poses of a drawing into a film: what a body carries along is drawn once, the rest frame by frame. */
#include "report/drawing/film_drawing.h"

#include "report/drawing/drawing_parts.h"

#include <stdint.h>

static const double width_default = 360, height_least = 150, height_most = 420; /* points: letters fit a phone */
static const double near = 0.05;                                                /* points: smaller differences are
                                                                                 * invisible */

typedef struct work {
  km_studio studio;
  km_film *film;
  bool *rigid;  /* [body] keeps its shape on the page */
  int *carrier; /* [item of the first frame] body that moves it; 0: it is fixed; or KM_FILM_DRAWN */
  km_scene first;
} work;

/* Planar displacement of a body on the page: a point, and cosine and sine of its rotation since the first frame. */
typedef struct stand {
  km_spot at;
  double cosine, sine;
} stand;

static const km_pose *pose_of(const work *w, size_t frame, int body) {
  const km_drawing_def *d = w->studio.drawing;
  return d->poses + frame * (size_t)d->mechanism->model->body_count + (size_t)body;
}

static stand position_of(const work *w, size_t frame, int body) {
  const km_pose *first = pose_of(w, 0, body), *now = pose_of(w, frame, body);
  const km_shape *shape = &w->studio.shapes[body];
  const km_vec3 point = shape->count ? shape->points[0] : (km_vec3){0, 0, 0}, right = w->studio.view.right;
  km_vec3 turned_right = km_rotate(&now->R, km_rotate_back(&first->R, right));
  km_spot turned = km_project_direction(&w->studio.view, turned_right);
  return (stand){km_project(&w->studio.view, km_pose_point(now, point)), turned.x, turned.y};
}

static void add_body(work *w, int body) {
  km_film_mover *mover = km_film_add_mover(w->film, true);
  double before = 0.0;
  w->rigid[body] = w->studio.view.planar;
  for (size_t f = 0; mover && f < w->film->frame_count; ++f) {
    stand s = position_of(w, f, body);
    mover->x[f] = s.at.x;
    mover->y[f] = s.at.y;
    before += remainder(atan2(s.sine, s.cosine) - before, 2.0 * M_PI);
    mover->angle[f] = before * 180.0 / M_PI;
    w->rigid[body] = w->rigid[body] && fabs(hypot(s.cosine, s.sine) - 1.0) < 1e-6;
  }
}

/* The body with which an item moves, if it keeps its shape. */
static int carrier_of(const work *w, const km_item *item) {
  if (item->kind == KM_ITEM_BASE || item->kind == KM_ITEM_MOUNT || item->kind == KM_ITEM_RAIL)
    return 0;
  int body = item->kind == KM_ITEM_SYMBOL
                 ? km_joint_body(w->first.mechanism->model, item->joint, !w->first.marks[item->joint].guide)
                 : item->body;
  return body == 0 || w->rigid[body] ? body : KM_FILM_DRAWN;
}

static bool has_spot(const km_item *item, km_spot spot) {
  for (int i = 0; i < item->count; ++i)
    if (km_spot_distance(item->spots[i], spot) < near)
      return true;
  return false;
}

/* True if the item equals the rigidly moved one; the corners of a plate may start at any corner. */
static bool is_carried(const work *w, size_t frame, int body, const km_item *first, const km_item *now) {
  stand from = position_of(w, 0, body), to = position_of(w, frame, body);
  if (first->count != now->count)
    return false;
  for (int i = 0; i < first->count; ++i) {
    double x = first->spots[i].x - from.at.x, y = first->spots[i].y - from.at.y;
    km_spot there = {to.at.x + to.cosine * x - to.sine * y, to.at.y + to.sine * x + to.cosine * y, 0};
    if (!has_spot(now, there))
      return false;
  }
  km_spot a = first->axis[0], b = now->axis[0];
  return fabs((to.cosine * a.x - to.sine * a.y) * b.y - (to.sine * a.x + to.cosine * a.y) * b.x) < 1e-3;
}

/* A scene of a frame; its memory is the arena's that is given. */
static km_scene scene_of(work *w, size_t frame, km_arena *arena) {
  km_scene scene = km_studio_scene(&w->studio, frame, 0.0);
  scene.arena = arena;
  km_scene_build(&scene);
  w->studio.arena.failed = w->studio.arena.failed || arena->failed;
  return scene;
}

static bool same_items(const km_scene *a, const km_scene *b) {
  bool same = a->count == b->count;
  for (size_t i = 0; i < a->count && same; ++i)
    same = a->items[i].kind == b->items[i].kind && a->items[i].joint == b->items[i].joint &&
           a->items[i].body == b->items[i].body;
  return same;
}

/* Finds what really moves with its carrier in every frame. False: other things are drawn in some frame than in the
 * first, or in another order. */
static bool find_carriers(work *w) {
  for (size_t i = 0; i < w->first.count; ++i)
    w->carrier[i] = carrier_of(w, &w->first.items[i]);
  for (size_t f = 1; f < w->film->frame_count; ++f) {
    km_arena arena = {0};
    km_scene now = scene_of(w, f, &arena);
    bool same = !arena.failed && same_items(&w->first, &now);
    for (size_t i = 0; i < w->first.count && same; ++i)
      if (w->carrier[i] > 0 && !is_carried(w, f, w->carrier[i], &w->first.items[i], &now.items[i]))
        w->carrier[i] = KM_FILM_DRAWN;
    km_arena_free(&arena);
    if (!same)
      return false;
  }
  return true;
}

/* Items from..to of every frame; the base is drawn once, under everything. */
static void redraw(work *w, size_t from, size_t to) {
  km_film_begin(w->film, KM_FILM_DRAWN);
  for (size_t f = 0; f < w->film->frame_count; ++f) {
    km_arena arena = {0};
    km_scene scene = scene_of(w, f, &arena);
    km_film_frame(w->film, f);
    for (size_t i = from; !arena.failed && i < scene.count && i < to; ++i)
      if (scene.items[i].kind != KM_ITEM_BASE)
        km_item_paint(&scene, w->film->canvas, &scene.items[i]);
    km_arena_free(&arena);
  }
}

/* Items from..to of the first frame, in the coordinates of the body that carries them. */
static void draw_carried(work *w, int body, size_t from, size_t to) {
  km_spot at = body ? position_of(w, 0, body).at : (km_spot){0, 0, 0};
  km_film_begin(w->film, body ? body - 1 : KM_FILM_STANDS);
  km_canvas_shift(w->film->canvas, -at.x, -at.y);
  for (size_t i = from; i < to; ++i)
    if (w->first.items[i].kind != KM_ITEM_BASE)
      km_item_paint(&w->first, w->film->canvas, &w->first.items[i]);
  km_canvas_shift(w->film->canvas, at.x, at.y);
}

static void draw_items(work *w) {
  size_t end;
  for (size_t i = 0; i < w->first.count; i = end) {
    for (end = i + 1; end < w->first.count && w->carrier[end] == w->carrier[i];)
      ++end;
    if (w->carrier[i] == KM_FILM_DRAWN)
      redraw(w, i, end);
    else
      draw_carried(w, w->carrier[i], i, end);
  }
}

/* A mover for every label, which follows what it names. */
static void add_followers(work *w, size_t count, size_t most) {
  size_t base = w->film->mover_count;
  km_label *labels = KM_ARENA_NEW(&w->studio.arena, km_label, most);
  for (size_t i = 0; i < count; ++i)
    km_film_add_mover(w->film, false);
  for (size_t f = 0; f < w->film->frame_count && labels && !w->film->arena->failed; ++f) {
    km_arena arena = {0};
    km_scene scene = scene_of(w, f, &arena);
    if (!arena.failed)
      km_studio_labels(&w->studio, &scene, labels);
    km_arena_free(&arena);
    for (size_t i = 0; i < count; ++i) {
      w->film->movers[base + i].x[f] = labels[i].at.x;
      w->film->movers[base + i].y[f] = labels[i].at.y;
    }
  }
}

/* The end of a path, and the name, about the origin: the mover carries them. */
static void draw_follower(work *w, int mover, const km_drawing_trace *trace, km_label *label, const km_font *font) {
  km_canvas_shift(w->film->canvas, -label->at.x, -label->at.y);
  if (trace && km_film_begin(w->film, mover))
    km_studio_draw_trace_point(&w->studio, trace, label->at);
  km_film_group *names = label->placed ? km_film_begin(w->film, mover) : NULL;
  if (names) {
    names->names = true;
    label->veiled = true; /* other links pass beneath it */
    km_label_paint(w->film->canvas, label, font);
  }
  km_canvas_shift(w->film->canvas, label->at.x, label->at.y);
}

static void draw_followers(work *w) {
  const km_drawing_def *d = w->studio.drawing;
  size_t most = km_studio_most_labels(&w->studio), base = w->film->mover_count;
  km_label *labels = KM_ARENA_NEW(&w->studio.arena, km_label, most);
  km_font font = km_studio_font(&w->studio);
  if (!labels)
    return;
  size_t count = km_studio_labels(&w->studio, &w->first, labels);
  if (d->bare)
    count = d->trace_count;
  else
    km_labels_place(w->film->canvas, &w->first, d->traces, d->trace_count, labels, count, &font, w->studio.place);
  add_followers(w, count, most);
  for (size_t i = 0; i < count && !w->film->arena->failed; ++i)
    draw_follower(w, (int)(base + i), i < d->trace_count ? &d->traces[i] : NULL, &labels[i], &font);
}

static void draw_film(work *w) {
  const km_drawing_def *d = w->studio.drawing;
  w->rigid = KM_ARENA_NEW(&w->studio.arena, bool, (size_t)d->mechanism->model->body_count);
  w->first = scene_of(w, 0, &w->studio.arena);
  w->carrier = KM_ARENA_NEW(&w->studio.arena, int, w->first.count + 1);
  if (w->studio.arena.failed)
    return;
  for (int b = 1; b < d->mechanism->model->body_count; ++b)
    add_body(w, b);
  km_film_begin(w->film, KM_FILM_STANDS);
  km_scene_paint_base(&w->first, w->film->canvas);
  km_studio_draw_traces(&w->studio);
  if (w->studio.view.planar && find_carriers(w))
    draw_items(w);
  else
    redraw(w, 0, SIZE_MAX);
  draw_followers(w);
}

/* Height by the shape, within bounds. */
static km_status find_height(const km_drawing_def *drawing, double width, double *height, km_error *error) {
  km_studio s = {.drawing = drawing, .place = {0, 0, width, width}};
  *height = width;
  if (km_studio_open(&s)) {
    double across = s.extent.high[0] - s.extent.low[0], up = s.extent.high[1] - s.extent.low[1];
    *height = across > 0.0 ? 60.0 + (width - 60.0) * up / across : height_most;
  }
  *height = fmin(fmax(*height, height_least), height_most);
  return km_studio_close(&s, error);
}

km_status km_drawing_film(const km_drawing_def *drawing, km_arena *arena, km_film *film, km_error *error) {
  km_drawing_def steady = *drawing;
  steady.alone = steady.steady = true;
  steady.full = 0;
  steady.meshes = NULL;
  double width = drawing->width > 0.0 ? drawing->width : width_default;
  double height = drawing->height;
  km_status status = height > 0.0 ? KM_OK : find_height(&steady, width, &height, error);
  if (status)
    return status;
  status = km_film_open(film, arena, width, height, drawing->pose_count, error);
  if (status)
    return status;
  work w = {.studio = {.drawing = &steady, .canvas = film->canvas, .place = {0, 0, width, height}}, .film = film};
  if (km_studio_open(&w.studio))
    draw_film(&w);
  status = km_studio_close(&w.studio, error);
  return status ? status : km_film_end(film, error);
}
