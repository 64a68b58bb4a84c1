/* Lists points of a cubic lattice, axis by axis. */
#include "arm/methods/ball_lattice.h"

enum { MOST_STEPS = 8, MOST_POINTS = 33 };

typedef struct listing {
  int freedom, most; /* counting ends beyond `most` points */
  int *steps;        /* [freedom] of the point in the making */
  double size;       /* of a step */
  double *out;       /* NULL: points are only counted */
  int count;
} listing;

/* Adds the points with the steps so far along the axes before `axis`; `left`: of the squared length. Along an axis 0 comes first, then
 * −1, 1, −2, 2 … */
static void add_points(listing *l, int axis, int left) {
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

static int list(listing *l, int each) {
  l->count = 0;
  add_points(l, 0, each * each);
  return l->count;
}

bool km_lattice_make(int freedom, double radius, double wanted, km_arena *arena, km_lattice *out) {
  const int fewest = 2 * freedom + 1;
  *out = (km_lattice){.each = 1};
  listing l = {.freedom = freedom,
               .most = MOST_POINTS > fewest ? MOST_POINTS : fewest,
               .steps = KM_ARENA_NEW(arena, int, (size_t)freedom + 1)};
  if (!l.steps)
    return false;
  while (out->each < wanted && out->each < MOST_STEPS && list(&l, out->each + 1) <= l.most)
    ++out->each;
  out->wider = freedom > 0 && out->each < wanted;
  out->count = list(&l, out->each);
  out->points = KM_ARENA_NEW(arena, double, (size_t)out->count *(size_t)(freedom + 1));
  l.size = radius / out->each;
  l.out = out->points;
  if (l.out)
    list(&l, out->each);
  return l.out != NULL;
}
