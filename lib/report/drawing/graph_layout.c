/* Tidy tree layout: columns from left to right for the subtrees of a body, the body above their middle. */
#include "report/drawing/graph_layout.h"

#include <math.h>

static const double step = 150.0;   /* distance between levels */
static const double half = 18.0;    /* unit: node heights */
static const double arrow = 10.0;   /* its length */
static const double letter = 7.0;   /* an average one's width, rather more */
static const double between = 30.0; /* nodes */
static const double text = 28.0;    /* height of a joint's label and type */
static const double upright = 48.0; /* so far above its lower end an arc goes straight down, beside its label */
static const double box = 30.0;     /* half of a node's width, and how far a line leaves it sideways */
static const double sag = 0.4;      /* unit: steps; depth of lines within a level below it */

int km_graph_width(const char *label) {
  int count = 0;
  for (; *label; ++label)
    count += ((unsigned char)*label & 0xC0) != 0x80; /* no byte that goes on */
  return count;
}

/* The widest label determines the width: a node's label is centred in its column, an arc's is right of the middle. */
static double find_pitch(const km_mechanism *m) {
  int widest = 0;
  for (int b = 0; b < m->model->body_count; ++b) {
    int width = km_graph_width(m->model->bodies[b].name);
    widest = width > widest ? width : widest;
  }
  for (int j = 0; j < m->model->joint_count; ++j) {
    int width = km_graph_width(m->model->joints[j].label),
        word = km_graph_width(km_joint_kind_of(m->model->joints[j].type)->word);
    width = width > word ? width : word;
    widest = width > widest ? width : widest;
  }
  return between + letter * widest;
}

static int tail_of(const km_mechanism *m, int loop) {
  return km_joint_body(m->model, m->topology.chord[loop], 0);
}

/* Computes the number of columns of each body, width[body]. */
static void count_columns(const km_mechanism *m, int *width) {
  const km_topology *t = &m->topology;
  for (int l = 0; l < t->loop_count; ++l)
    width[tail_of(m, l)]++;
  for (int i = t->body_count - 1; i > 0; --i) {
    int body = t->order[i];
    width[body] += width[body] == 0;
    width[t->parent[body]] += width[body];
  }
  width[0] += width[0] == 0;
}

static double middle(const km_graph_places *p, int column, int width) {
  return p->pitch * (column + 0.5 * width);
}

/* Assigns positions from the inertial frame on; next[body] is the next free column of the body. */
static void place(const km_mechanism *m, const int *width, int *next, km_graph_places *p) {
  const km_topology *t = &m->topology;
  p->body[0] = middle(p, 0, width[0]);
  for (int i = 1; i < t->body_count; ++i) {
    int body = t->order[i], parent = t->parent[body];
    next[body] = next[parent];
    next[parent] += width[body];
    p->body[body] = middle(p, next[body], width[body]);
  }
  for (int l = 0; l < t->loop_count; ++l) {
    int tail = tail_of(m, l);
    p->loop[l] = middle(p, next[tail]++, 1);
    p->level[l] = t->level[tail] + 1;
  }
}

bool km_graph_places_find(const km_mechanism *m, km_graph_places *out) {
  size_t bodies = (size_t)m->topology.body_count, loops = (size_t)m->topology.loop_count;
  *out = (km_graph_places){.pitch = find_pitch(m)};
  int *width = KM_ARENA_NEW(&out->arena, int, bodies), *next = KM_ARENA_NEW(&out->arena, int, bodies);
  out->body = KM_ARENA_NEW(&out->arena, double, bodies);
  out->loop = KM_ARENA_NEW(&out->arena, double, loops);
  out->level = KM_ARENA_NEW(&out->arena, int, loops);
  if (out->arena.failed)
    return false;
  count_columns(m, width);
  place(m, width, next, out);
  return true;
}

void km_graph_places_free(km_graph_places *p) {
  km_arena_free(&p->arena);
}

void km_graph_place_node(double x, int level, km_text *out) {
  km_text_format(out, " pos=\"%.1f,%.1f\"", x, -step * level);
}

void km_graph_place_arc(double from, double to, int level, int width, bool back, km_text *out) {
  const double top = -step * (level - 1) - half, bottom = half - step * level, turn = bottom + upright;
  const double first = back ? top - arrow : top, last = back ? bottom : bottom + arrow, halfway = 0.5 * (first + turn);
  km_text_format(out, " lp=\"%.1f,%.1f\" pos=\"%c,%.1f,%.1f ", to + 0.5 * letter * width, bottom + arrow + 0.5 * text,
                 back ? 's' : 'e', back ? from : to, back ? top : bottom);
  km_text_format(out, "%.1f,%.1f %.1f,%.1f %.1f,%.1f %.1f,%.1f ", from, first, from, halfway, to, halfway, to, turn);
  km_text_format(out, "%.1f,%.1f %.1f,%.1f %.1f,%.1f\"", to, turn, to, last, to, last);
}

/* From side to side, so that it lies between the columns; under the nodes of a level where it stays in it. */
void km_graph_place_line(double from, int level, double to, int to_level, km_text *out) {
  const double side = to < from ? -1.0 : 1.0, other = fabs(to - from) < 2.0 * box ? side : -side;
  const double x = from + side * box, end = to + other * box, dip = to_level == level ? -sag * step : 0.0;
  const double y = -step * level, to_y = -step * to_level;
  km_text_format(out, " pos=\"%.1f,%.1f %.1f,%.1f %.1f,%.1f %.1f,%.1f\"", x, y, x + side * box, y + dip,
                 end + other * box, to_y + dip, end, to_y);
}
