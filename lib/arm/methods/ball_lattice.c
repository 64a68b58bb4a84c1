/* Recursive enumeration of the integer lattice points within a ball. */
#include "arm/methods/ball_lattice.h"

enum { MAX_STEPS = 8, MAX_POINTS = 33 };

typedef struct point_list {
  int freedom, most; /* enumeration stops above `most` points */
  int *steps;        /* [freedom] lattice coordinates of the current point */
  double size;       /* size of a step */
  double *out;       /* NULL: points are counted only */
  int count;
} point_list;

/* Adds all points that have the given coordinates before `axis`; `left` is the rest of the squared radius. Order
 * along an axis: 0, −1, 1, −2, 2 … */
static void add_points(point_list *l, int axis, int left) {
  if (axis == l->freedom) {
    for (int k = 0; k < l->freedom && l->out; ++k)
      l->out[l->count * l->freedom + k] = l->size * l->steps[k];
    ++l->count;
    return;
  }
  for (int i = 0; (i + 1) / 2 * ((i + 1) / 2) <= left && l->count <= l->most; ++i) {
    int step = i % 2 ? -(i + 1) / 2 : i / 2;
    l->steps[axis] = step;
    add_points(l, axis + 1, left - step * step);
  }
}

static int list_points(point_list *l, int steps_per_radius) {
  l->count = 0;
  add_points(l, 0, steps_per_radius * steps_per_radius);
  return l->count;
}

bool km_lattice_create(int freedom, double radius, double wanted, km_arena *arena, km_lattice *out) {
  const int min_points = 2 * freedom + 1;
  *out = (km_lattice){.steps_per_radius = 1};
  point_list l = {.freedom = freedom,
                  .most = MAX_POINTS > min_points ? MAX_POINTS : min_points,
                  .steps = KM_ARENA_NEW(arena, int, (size_t)freedom + 1)};
  if (!l.steps)
    return false;
  while (out->steps_per_radius < wanted && out->steps_per_radius < MAX_STEPS &&
         list_points(&l, out->steps_per_radius + 1) <= l.most)
    ++out->steps_per_radius;
  out->is_coarse = freedom > 0 && out->steps_per_radius < wanted;
  out->count = list_points(&l, out->steps_per_radius);
  out->points = KM_ARENA_NEW(arena, double, (size_t)out->count *(size_t)(freedom + 1));
  l.size = radius / out->steps_per_radius;
  l.out = out->points;
  if (l.out)
    list_points(&l, out->steps_per_radius);
  return l.out != NULL;
}
