/* The outline of a plate. */
#include "report/drawing/drawing_parts.h"

#include <stdlib.h>

static double turn_of(km_spot a, km_spot b, km_spot c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static int by_place(const void *x, const void *y) {
  const km_spot *a = x, *b = y;
  return a->x != b->x ? (a->x > b->x) - (a->x < b->x) : (a->y > b->y) - (a->y < b->y);
}

/* Andrew's chain: along the one side, and back along the other. */
int km_convex_hull(km_spot *spots, int count, km_spot *hull) {
  int corners = 0;
  qsort(spots, (size_t)count, sizeof *spots, by_place);
  for (int pass = 0; pass < 2; ++pass) {
    int lower = corners;
    for (int i = 0; i < count; ++i) {
      km_spot next = spots[pass ? count - 1 - i : i];
      while (corners >= lower + 2 && turn_of(hull[corners - 2], hull[corners - 1], next) <= 0.0)
        --corners;
      hull[corners++] = next;
    }
    --corners; /* the last is the first of the other pass */
  }
  return corners;
}
