/* Drawings of mechanisms: view, scale and symbol sizes, then the scene of each pose. */
#include "report/drawing/drawing_parts.h"

#include "report/canvas/palette.h"

#include <stdlib.h>

enum { MOST_LABELS = 1000 }; /* limit of labels: placement takes count² */

static const km_pose *pose_of(const km_studio *s, size_t index) {
  return s->drawing->poses + index * (size_t)s->drawing->mechanism->model->body_count;
}

km_scene km_studio_scene(km_studio *s, size_t index, double fade) {
  bool alone = s->drawing->alone && !s->drawing->steady;
  return (km_scene){.mechanism = s->drawing->mechanism,
                    .pose = pose_of(s, index),
                    .poses = pose_of(s, alone ? index : 0),
                    .pose_count = alone ? 1 : s->drawing->pose_count,
                    .shapes = s->shapes,
                    .marks = s->marks,
                    .surfaces = s->surfaces,
                    .view = &s->view,
                    .arena = &s->arena,
                    .radius = s->radius,
                    .fade = fade,
                    .steady = s->drawing->steady,
                    .halo = !s->view.planar};
}

static int by_size(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The distance on the page from joints to their next neighbours in another place: the lower
 * quartile. */
static double overlap(km_studio *s, const km_spot *spots, int count) {
  double *nearest = KM_ARENA_NEW(&s->arena, double, (size_t)count), least = 0.5 * s->radius;
  int found = 0;
  for (int i = 0; nearest && i < count; ++i) {
    double best = HUGE_VAL;
    for (int k = 0; k < count; ++k) {
      double distance = km_spot_distance(spots[i], spots[k]);
      best = distance > least && distance < best ? distance : best;
    }
    if (isfinite(best))
      nearest[found++] = best;
  }
  if (found == 0)
    return HUGE_VAL;
  qsort(nearest, (size_t)found, sizeof *nearest, by_size);
  return nearest[found / 4];
}

/* Symbols shrink where joints are close together. */
static void choose_radius(km_studio *s) {
  int count = s->drawing->mechanism->model->joint_count;
  km_scene scene = km_studio_scene(s, s->drawing->full, 0.0);
  km_spot *spots = KM_ARENA_NEW(&s->arena, km_spot, (size_t)count);
  s->radius = 4.4 * s->size;
  for (int j = 0; spots && j < count; ++j)
    spots[j] = km_project(&s->view, km_joint_place(&scene, j));
  if (spots)
    s->radius = fmax(fmin(s->radius, 0.24 * overlap(s, spots, count)), 0.4 * s->radius);
}

static double size_of(km_rectangle place) {
  return fmin(fmax(sqrt(fmin(place.width / 486.0, place.height / 260.0)), 0.3), 1.5);
}

km_rectangle km_studio_inner(const km_studio *s) {
  const km_rectangle *p = &s->place;
  double pad = fmin((s->drawing->bare ? 18.0 : 30.0) * s->size, 0.2 * fmin(p->width, p->height));
  return (km_rectangle){p->left + pad, p->top + pad, p->width - 2.0 * pad, p->height - 2.0 * pad};
}

bool km_studio_open(km_studio *s) {
  s->size = size_of(s->place);
  s->shapes = km_shapes_make(s->drawing->mechanism->model, &s->arena);
  s->marks = s->shapes ? km_marks_make(s->drawing->mechanism->model, s->shapes, &s->arena) : NULL;
  s->surfaces = km_surfaces_make(s->drawing, &s->arena);
  if (s->arena.failed)
    return false;
  s->view = km_view_make(s->drawing);
  s->extent = km_extent_of(s->drawing, s->shapes, &s->view);
  km_projection_fit(&s->view, &s->extent, km_studio_inner(s));
  choose_radius(s);
  return !s->arena.failed;
}

/* There may be hundreds: each gives its memory back. */
static void draw_ghost(km_studio *s, size_t index, double fade) {
  km_arena arena = {0};
  km_scene ghost = km_studio_scene(s, index, fade);
  ghost.arena = &arena;
  km_scene_build(&ghost);
  if (!arena.failed)
    km_scene_paint(&ghost, s->canvas);
  s->arena.failed = s->arena.failed || arena.failed;
  km_arena_free(&arena);
}

/* The farther from the full pose, the paler. */
static void draw_ghosts(km_studio *s) {
  size_t count = s->drawing->pose_count, full = s->drawing->full;
  size_t most = full > count - 1 - full ? full : count - 1 - full;
  for (size_t away = most; away > 0 && !s->drawing->alone; --away)
    for (int side = -1; side <= 1; side += 2) {
      size_t index = side < 0 ? full - away : full + away;
      if (index >= count) /* below 0 too */
        continue;
      draw_ghost(s, index, 0.52 + 0.3 * (double)away / (double)(most + 1));
    }
}

km_spot km_trace_spot(const km_scene *scene, const km_drawing_trace *trace) {
  return km_project(scene->view, km_frame_origin(scene->mechanism->model, scene->pose, trace->frame));
}

static int trace_colour(const km_studio *s, const km_drawing_trace *trace) {
  return s->shapes[s->drawing->mechanism->model->frames[trace->frame].body].colour;
}

void km_studio_draw_traces(km_studio *s) {
  for (size_t t = 0; t < s->drawing->trace_count; ++t) {
    const km_drawing_trace *trace = &s->drawing->traces[t];
    km_canvas_point *points = KM_ARENA_NEW(&s->arena, km_canvas_point, trace->count);
    for (size_t i = 0; points && i < trace->count; ++i) {
      km_spot at = km_project(&s->view, trace->points[i]);
      points[i] = (km_canvas_point){at.x, at.y};
    }
    km_pen pen = {.colour = km_palette_text(trace_colour(s, trace)), .width = 1.1 * s->size};
    if (points && trace->count > 1)
      km_canvas_polyline(s->canvas, &pen, points, trace->count);
  }
}

void km_studio_draw_trace_point(const km_studio *s, const km_drawing_trace *trace, km_spot at) {
  km_canvas_circle(s->canvas, km_palette_text(trace_colour(s, trace)), NULL, (km_canvas_point){at.x, at.y},
                   0.55 * s->radius);
}

/* The middle of the largest thing that is drawn of a body; where nothing is, of its points. */
static km_spot middle_of(const km_studio *s, const km_scene *scene, int body) {
  const km_shape *shape = &s->shapes[body];
  km_spot middle = km_project(&s->view, km_pose_point(&scene->pose[body], shape->points[0]));
  double largest = 0.0;
  for (size_t i = 0; i < scene->count; ++i) {
    const km_item *item = &scene->items[i];
    double size = item->body == body ? km_spot_distance(item->spots[0], item->spots[item->count / 2]) : 0.0;
    if (size <= largest)
      continue;
    largest = size;
    middle = (km_spot){0, 0, item->depth};
    for (int k = 0; k < item->count; ++k) {
      middle.x += item->spots[k].x / item->count;
      middle.y += item->spots[k].y / item->count;
    }
  }
  return middle;
}

size_t km_studio_most_labels(const km_studio *s) {
  const km_model *model = s->drawing->mechanism->model;
  return (size_t)model->joint_count + s->drawing->trace_count + (size_t)model->body_count + (size_t)model->load_count;
}

size_t km_studio_labels(const km_studio *s, const km_scene *scene, km_label *labels) {
  const km_drawing_def *d = s->drawing;
  const km_model *model = d->mechanism->model;
  size_t count = 0;
  for (size_t t = 0; t < d->trace_count; ++t)
    labels[count++] = (km_label){.text = d->traces[t].name,
                                 .at = km_trace_spot(scene, &d->traces[t]),
                                 .radius = s->radius,
                                 .colour = trace_colour(s, &d->traces[t])};
  for (int i = 0; i < model->load_count && d->loads; ++i) {
    km_spot ends[2];
    if (km_load_arrow(s, scene, i, ends))
      labels[count++] = (km_label){.text = model->loads[i].name,
                                   .at = ends[0],
                                   .radius = 1.0,
                                   .colour = KM_LOAD_COLOUR,
                                   .arrow = true,
                                   .tip = ends[1]};
  }
  for (int j = 0; j < model->joint_count; ++j)
    labels[count++] = (km_label){.text = model->joints[j].label,
                                 .at = km_project(&s->view, km_joint_place(scene, j)),
                                 .radius = km_symbol_reach(scene, j),
                                 .colour = KM_BLACK};
  for (int b = 1; b < model->body_count && d->bodies; ++b)
    labels[count++] = (km_label){.text = model->bodies[b].name,
                                 .at = middle_of(s, scene, b),
                                 .radius = s->radius,
                                 .colour = s->shapes[b].colour,
                                 .inside = true};
  return count < MOST_LABELS ? count : MOST_LABELS;
}

km_font km_studio_font(const km_studio *s) {
  km_font font = {.size = fmin(fmax(8.0 * s->size, 6.5), 11.0)};
  font.width = fmin(16.0 * font.size, 0.3 * s->place.width);
  return font;
}

static void draw_labels(km_studio *s, const km_scene *scene) {
  km_label *labels = KM_ARENA_NEW(&s->arena, km_label, km_studio_most_labels(s));
  if (!labels || s->drawing->bare)
    return;
  size_t count = km_studio_labels(s, scene, labels);
  km_font font = km_studio_font(s);
  km_labels_place(s->canvas, scene, s->drawing->traces, s->drawing->trace_count, labels, count, &font, s->place);
  for (size_t i = 0; i < count; ++i)
    if (labels[i].placed)
      km_label_paint(s->canvas, &labels[i], &font);
}

void km_studio_draw(km_studio *s) {
  km_scene scene = km_studio_scene(s, s->drawing->full, 0.0);
  km_scene_build(&scene);
  if (s->arena.failed)
    return;
  km_scene_paint_base(&scene, s->canvas);
  draw_ghosts(s);
  km_studio_draw_traces(s);
  km_scene_paint(&scene, s->canvas);
  for (size_t t = 0; t < s->drawing->trace_count; ++t)
    km_studio_draw_trace_point(s, &s->drawing->traces[t], km_trace_spot(&scene, &s->drawing->traces[t]));
  km_studio_draw_loads(s, &scene);
  draw_labels(s, &scene);
}

km_status km_studio_close(km_studio *s, km_error *error) {
  bool failed = s->arena.failed;
  km_arena_free(&s->arena);
  return failed ? km_fail(error, KM_MEMORY, "out of memory for a drawing") : KM_OK;
}

km_status km_drawing_place(const km_drawing_def *drawing, km_canvas *canvas, km_rectangle place, km_error *error) {
  km_studio s = {.drawing = drawing, .canvas = canvas, .place = place};
  if (km_studio_open(&s))
    km_studio_draw(&s);
  return km_studio_close(&s, error);
}
