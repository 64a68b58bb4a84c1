/* Names beside what they name. Every label tries places around its spot, nearer ones first; the
 * cheapest is taken, and once all have a place each looks again. */
#include "report/canvas/palette.h"
#include "report/drawing/page_grid.h"

enum { DIRECTIONS = 16, RINGS = 7, ROUNDS = 3 };
static const double ring_sizes[RINGS] = {0.15, 0.45, 1.1, 2.0, 3.2, 4.8, 7.0}; /* em */
static const double clash = 1e6; /* overlapping another name: rather none at all */
static const double cost_symbol = 100.0, cost_edge = 3.0, cost_leader = 25.0, cost_distance = 1.1;

/* Part of the picture, as a segment with a width. */
typedef struct obstacle {
  km_spot a, b;
  double reach;
  bool symbol;
  double length;
} obstacle;

/* A placed label: whether it has a leader, and the leader's end. */
typedef struct placed_label {
  size_t index;
  bool has_leader;
  km_canvas_point end;
} placed_label;

typedef struct board {
  km_label *labels;
  size_t count;
  obstacle *obstacles;
  size_t obstacle_count;
  km_grid grid;         /* grid of the obstacles */
  placed_label *placed; /* [placed_count] */
  size_t placed_count;
  km_rectangle place;
  unsigned changes; /* cost of the placement so far */
  unsigned *looked; /* [count] the changes when a label last looked for a place */
  double em;        /* size of the letters */
  double worst;     /* largest cost of a place; a name without a cheaper place is omitted */
} board;

/* Ground lies beside the spots of its item. */
static void add_ground(board *b, const km_item *item, double radius) {
  bool rail = item->kind == KM_ITEM_RAIL;
  km_spot away = rail ? km_rail_side(item) : item->axis[0];
  double off = rail ? 2.0 * radius : 2.4 * radius;
  obstacle *o = &b->obstacles[b->obstacle_count++];
  *o = (obstacle){item->spots[0], item->spots[item->count - 1], rail ? 1.6 * radius : 2.3 * radius, true, 0.0};
  o->a.x += off * away.x;
  o->a.y += off * away.y;
  o->b.x += off * away.x;
  o->b.y += off * away.y;
}

static void add_edges(board *b, const km_item *item) {
  bool symbol = item->count == 1;
  int edges = item->count > 2 ? item->count : 1;
  for (int i = 0; i < edges; ++i)
    b->obstacles[b->obstacle_count++] =
        (obstacle){item->spots[i], item->spots[(i + 1) % item->count], item->reach, symbol, 0.0};
}

enum { TRACE_STEPS = 48 };

static void add_trace(board *b, const km_projection *view, const km_drawing_trace *trace) {
  for (size_t i = 0; i < TRACE_STEPS && trace->count; ++i) {
    size_t from = i * (trace->count - 1) / TRACE_STEPS, to = (i + 1) * (trace->count - 1) / TRACE_STEPS;
    b->obstacles[b->obstacle_count++] =
        (obstacle){km_project(view, trace->points[from]), km_project(view, trace->points[to]), 0.5, false, 0.0};
  }
}

/* The arrow that begins at a label's spot, as wide as its head. */
static void add_arrow(board *b, const km_label *label) {
  b->obstacles[b->obstacle_count++] = (obstacle){label->at, label->tip, 0.4 * b->em, true, 0.0};
}

static bool gather(board *b, const km_scene *scene, const km_drawing_trace *traces, size_t trace_count) {
  size_t most = trace_count * TRACE_STEPS + b->count;
  for (size_t i = 0; i < scene->count; ++i)
    most += (size_t)scene->items[i].count;
  b->obstacles = KM_ARENA_NEW(scene->arena, obstacle, most);
  for (size_t i = 0; b->obstacles && i < scene->count; ++i)
    if (scene->items[i].kind == KM_ITEM_MOUNT || scene->items[i].kind == KM_ITEM_RAIL)
      add_ground(b, &scene->items[i], scene->radius);
    else
      add_edges(b, &scene->items[i]);
  for (size_t t = 0; b->obstacles && t < trace_count; ++t)
    add_trace(b, scene->view, &traces[t]);
  for (size_t i = 0; b->obstacles && i < b->count; ++i)
    if (b->labels[i].arrow)
      add_arrow(b, &b->labels[i]);
  for (size_t i = 0; b->obstacles && i < b->obstacle_count; ++i)
    b->obstacles[i].length = km_spot_distance(b->obstacles[i].a, b->obstacles[i].b);
  b->placed = KM_ARENA_NEW(scene->arena, placed_label, b->count);
  b->looked = KM_ARENA_NEW(scene->arena, unsigned, b->count);
  return !scene->arena->failed;
}

/* Where an obstacle lies, with its width. */
static km_rectangle frame_of(const obstacle *o) {
  return (km_rectangle){fmin(o->a.x, o->b.x) - o->reach, fmin(o->a.y, o->b.y) - o->reach,
                        fabs(o->b.x - o->a.x) + 2.0 * o->reach, fabs(o->b.y - o->a.y) + 2.0 * o->reach};
}

static bool make_grid(board *b, km_arena *arena) {
  km_rectangle *frames = KM_ARENA_NEW(arena, km_rectangle, b->obstacle_count);
  for (size_t i = 0; frames && i < b->obstacle_count; ++i)
    frames[i] = frame_of(&b->obstacles[i]);
  return frames && km_grid_make(&b->grid, b->place, 2.0 * b->em, frames, b->obstacle_count, arena);
}

/* Narrows the part low..high of a segment that lies within from..to in one direction. */
static void narrow(double start, double run, double from, double to, double *low, double *high) {
  if (fabs(run) < 1e-12) {
    if (start < from || start > to)
      *high = -1.0;
    return;
  }
  double a = (from - start) / run, b = (to - start) / run;
  *low = fmax(*low, fmin(a, b));
  *high = fmin(*high, fmax(a, b));
}

/* True if two coordinates are both below `low` or both above `high`: excludes most obstacles. */
static bool adjacent(double a, double b, double low, double high) {
  return (a < low && b < low) || (a > high && b > high);
}

/* The part of a segment that lies within a rectangle that is `reach` larger all around; negative: none. */
static double inside(const obstacle *o, km_canvas_point box, km_canvas_point size) {
  double left = box.x - o->reach, right = box.x + size.x + o->reach;
  double top = box.y - o->reach, bottom = box.y + size.y + o->reach;
  if (adjacent(o->a.x, o->b.x, left, right) || adjacent(o->a.y, o->b.y, top, bottom))
    return -1.0;
  double low = 0.0, high = 1.0;
  narrow(o->a.x, o->b.x - o->a.x, left, right, &low, &high);
  narrow(o->a.y, o->b.y - o->a.y, top, bottom, &low, &high);
  return high < low ? -1.0 : high - low;
}

/* Counted until it reaches `bound`. */
static double picture_cost(board *b, km_canvas_point box, km_canvas_point size, double bound) {
  double cost = 0.0;
  km_grid_query(&b->grid, (km_rectangle){box.x, box.y, size.x, size.y});
  for (int i = km_grid_next(&b->grid); i >= 0 && cost < bound; i = km_grid_next(&b->grid)) {
    const obstacle *o = &b->obstacles[i];
    double share = inside(o, box, size);
    if (share >= 0.0)
      cost += o->symbol ? cost_symbol : 4.0 + cost_edge * (share * o->length);
  }
  return cost;
}

static bool overlap(km_canvas_point a, km_canvas_point size_a, km_canvas_point b, km_canvas_point size_b) {
  return a.x < b.x + size_b.x && b.x < a.x + size_a.x && a.y < b.y + size_b.y && b.y < a.y + size_a.y;
}

static bool outside(const board *b, km_canvas_point box, km_canvas_point size) {
  const km_rectangle *p = &b->place;
  return box.x < p->left || box.y < p->top || box.x + size.x > p->left + p->width ||
         box.y + size.y > p->top + p->height;
}

/* The point of a label's box that is nearest to its spot. */
static km_canvas_point leader_end(const km_label *label, km_canvas_point box) {
  return (km_canvas_point){fmin(fmax(label->at.x, box.x), box.x + label->size.x),
                           fmin(fmax(label->at.y, box.y), box.y + label->size.y)};
}

static double leader_length(const km_label *label, km_canvas_point box) {
  km_canvas_point end = leader_end(label, box);
  return hypot(end.x - label->at.x, end.y - label->at.y) - label->radius;
}

static bool has_leader(double em, const km_label *label, km_canvas_point box) {
  return leader_length(label, box) > 0.75 * em;
}

static bool crosses(km_canvas_point a, km_canvas_point b, km_canvas_point c, km_canvas_point d) {
  double abc = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x),
         abd = (b.x - a.x) * (d.y - a.y) - (b.y - a.y) * (d.x - a.x);
  double cda = (d.x - c.x) * (a.y - c.y) - (d.y - c.y) * (a.x - c.x),
         cdb = (d.x - c.x) * (b.y - c.y) - (d.y - c.y) * (b.x - c.x);
  return abc * abd < 0.0 && cda * cdb < 0.0;
}

/* A leader must not run through names, other symbols or other leaders. Counted until it reaches `bound`. */
static double leader_cost(board *b, const km_label *label, km_canvas_point box, double bound) {
  km_canvas_point end = leader_end(label, box), at = {label->at.x, label->at.y};
  obstacle leader = {.a = label->at, .b = {end.x, end.y, 0.0}};
  double cost = cost_leader;
  for (size_t i = 0; i < b->placed_count && cost < bound; ++i) {
    const placed_label *placed = &b->placed[i];
    const km_label *other = &b->labels[placed->index];
    km_canvas_point other_at = {other->at.x, other->at.y};
    cost += inside(&leader, other->box, other->size) >= 0.0 ? 4.0 * cost_symbol : 0.0;
    if (placed->has_leader && crosses(at, end, other_at, placed->end))
      cost += 2.0 * cost_symbol;
  }
  km_grid_query(&b->grid, frame_of(&leader));
  for (int i = km_grid_next(&b->grid); i >= 0 && cost < bound; i = km_grid_next(&b->grid)) {
    const obstacle *o = &b->obstacles[i];
    if (!o->symbol || km_spot_distance(o->a, label->at) < 0.5)
      continue;
    km_canvas_point corner = {o->a.x - o->reach, o->a.y - o->reach}, size = {2.0 * o->reach, 2.0 * o->reach};
    cost += inside(&leader, corner, size) >= 0.0 ? 0.7 * cost_symbol : 0.0;
  }
  return cost;
}

/* Cost of a box against other names and leaders, computed until it reaches `bound`. */
static double names_cost(const board *b, const km_label *label, km_canvas_point box, double bound) {
  double cost = 0.0;
  for (size_t i = 0; i < b->placed_count && cost < bound; ++i) {
    const placed_label *placed = &b->placed[i];
    const km_label *other = &b->labels[placed->index];
    cost += overlap(box, label->size, other->box, other->size) ? clash : 0.0;
    if (!placed->has_leader)
      continue;
    const obstacle leader = {.a = other->at, .b = {placed->end.x, placed->end.y, 0.0}};
    cost += inside(&leader, box, label->size) >= 0.0 ? 4.0 * cost_symbol : 0.0;
  }
  return cost;
}

/* The cheap parts first: what reaches `bound` needs no closer look. */
static double cost_of(board *b, const km_label *label, km_canvas_point box, double bound) {
  double cost = cost_distance * fmax(leader_length(label, box), 0.0);
  if (cost < bound)
    cost += picture_cost(b, box, label->size, bound - cost);
  if (cost < bound)
    cost += names_cost(b, label, box, bound - cost);
  if (cost < bound && has_leader(b->em, label, box))
    cost += leader_cost(b, label, box, bound - cost);
  return cost;
}

static km_canvas_point box_at(const board *b, const km_label *label, int ring, int direction) {
  double angle = 2.0 * M_PI * (direction + 0.5 * (ring % 2)) / DIRECTIONS - 0.25 * M_PI; /* right above first */
  double x = cos(angle), y = sin(angle), off = label->radius + ring_sizes[ring] * b->em;
  /* The box touches the circle about the spot with the side or corner that faces it. */
  double across = fmin(fmax(1.3 * x, -1.0), 1.0), down = fmin(fmax(1.3 * y, -1.0), 1.0);
  return (km_canvas_point){label->at.x + off * x + 0.5 * (across - 1.0) * label->size.x,
                           label->at.y + off * y + 0.5 * (down - 1.0) * label->size.y};
}

static km_canvas_point box_over(const km_label *label) {
  return (km_canvas_point){label->at.x - 0.5 * label->size.x, label->at.y - 0.5 * label->size.y};
}

/* The label gives its place up, to look for a better one. */
static void leave(board *b, size_t index) {
  if (!b->labels[index].placed)
    return;
  b->labels[index].placed = false;
  size_t i = 0;
  while (b->placed[i].index != index)
    ++i;
  b->placed[i] = b->placed[--b->placed_count];
}

/* Where no label has found another place since this one looked, it would find what it has. */
static void place_label(board *b, size_t index) {
  km_label *label = &b->labels[index], before = *label;
  double least = b->worst;
  if (b->looked[index] == b->changes)
    return;
  leave(b, index);
  for (int ring = label->inside ? -1 : 0; ring < RINGS; ++ring)
    for (int d = 0; d < (ring < 0 ? 1 : DIRECTIONS); ++d) {
      km_canvas_point box = ring < 0 ? box_over(label) : box_at(b, label, ring, d);
      if (outside(b, box, label->size))
        continue;
      double cost = cost_of(b, label, box, least) + 0.02 * d;
      if (cost >= least)
        continue;
      least = cost;
      label->box = box;
      label->placed = true;
    }
  if (label->placed)
    b->placed[b->placed_count++] =
        (placed_label){index, has_leader(b->em, label, label->box), leader_end(label, label->box)};
  bool stays = label->placed == before.placed && label->box.x == before.box.x && label->box.y == before.box.y;
  b->changes += !stays;
  b->looked[index] = b->changes;
}

void km_label_paint(km_canvas *canvas, const km_label *label, const km_font *font) {
  km_pen thin = {.colour = {0.45, 0.45, 0.45, 1}, .width = 0.07 * font->size};
  km_canvas_point end = leader_end(label, label->box);
  double x = end.x - label->at.x, y = end.y - label->at.y, length = hypot(x, y);
  if (has_leader(font->size, label, label->box) && length > 0.0)
    km_canvas_line(canvas, &thin,
                   (km_canvas_point){label->at.x + x / length * 0.8 * label->radius,
                                     label->at.y + y / length * 0.8 * label->radius},
                   end);
  if (label->veiled)
    km_canvas_rectangle(canvas, (km_colour){1, 1, 1, 0.7}, label->box.x, label->box.y, label->size.x, label->size.y);
  km_colour colour = label->colour == KM_BLACK ? (km_colour){0.1, 0.1, 0.1, 1} : km_palette_text(label->colour);
  km_canvas_text(canvas, font, colour, label->text, label->box, (km_anchor){0, 0, 0});
}

void km_labels_place(km_canvas *canvas, const km_scene *scene, const km_drawing_trace *traces, size_t trace_count,
                     km_label *labels, size_t count, const km_font *font, km_rectangle place) {
  board b = {.labels = labels, .count = count, .place = place, .em = font->size};
  double needed = 16.0 * b.em * b.em * (double)count;
  b.worst = needed > place.width * place.height ? 0.4 * cost_symbol : clash; /* no thicket of leaders */
  b.changes = 1;
  if (!gather(&b, scene, traces, trace_count) || !make_grid(&b, scene->arena))
    return;
  for (size_t i = 0; i < count; ++i)
    labels[i].size = km_canvas_measure(canvas, font, labels[i].text);
  for (int round = 0; round < ROUNDS; ++round)
    for (size_t i = 0; i < count; ++i)
      place_label(&b, i);
  for (size_t i = 0; i < count; ++i)
    labels[i].veiled = labels[i].placed && picture_cost(&b, labels[i].box, labels[i].size, clash) > 0.0;
}
