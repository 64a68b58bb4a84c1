/* Painter's order of items. Mean depths are wrong for long bars that cross, so pairs that overlap on the page are
 * compared at the overlap. */
#include "report/drawing/drawing_parts.h"

#include <stdlib.h>

enum { MOST_COMPARED = 1500 }; /* items: with more, pairwise comparison is slow and details are invisible */

/* Nearest points of two segments on the page: distance, and difference of depth. */
typedef struct meeting {
  double distance, depth;
} meeting;

static double limited(double t) {
  return fmin(fmax(t, 0.0), 1.0);
}

/* Parameter of the point of a-b that is nearest to p. */
static double nearest(km_spot a, km_spot b, km_spot p) {
  double x = b.x - a.x, y = b.y - a.y, square = x * x + y * y;
  return square > 0.0 ? limited(((p.x - a.x) * x + (p.y - a.y) * y) / square) : 0.5;
}

static km_spot at(km_spot a, km_spot b, double t) {
  return (km_spot){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.depth + t * (b.depth - a.depth)};
}

static void nearer(meeting *best, km_spot p, km_spot q) {
  double distance = km_spot_distance(p, q);
  if (distance < best->distance)
    *best = (meeting){distance, p.depth - q.depth};
}

static meeting meet(const km_spot a[2], const km_spot b[2]) {
  meeting best = {HUGE_VAL, 0.0};
  double ax = a[1].x - a[0].x, ay = a[1].y - a[0].y, bx = b[1].x - b[0].x, by = b[1].y - b[0].y;
  double cross = ax * by - ay * bx, cx = b[0].x - a[0].x, cy = b[0].y - a[0].y;
  if (fabs(cross) > 1e-9) {
    double t = (cx * by - cy * bx) / cross, u = (cx * ay - cy * ax) / cross;
    if (t >= 0.0 && t <= 1.0 && u >= 0.0 && u <= 1.0)
      return (meeting){0.0, at(a[0], a[1], t).depth - at(b[0], b[1], u).depth};
  }
  for (int k = 0; k < 2; ++k) {
    nearer(&best, a[k], at(b[0], b[1], nearest(b[0], b[1], a[k])));
    nearer(&best, at(a[0], a[1], nearest(a[0], a[1], b[k])), b[k]);
  }
  return best;
}

/* Edge i of an item; a single spot counts as an edge without length. */
static void edge(const km_item *item, int i, km_spot out[2]) {
  out[0] = item->spots[i];
  out[1] = item->spots[(i + 1) % item->count];
}

static int edges(const km_item *item) {
  return item->count > 2 ? item->count : 1;
}

/* > 0: a lies in front of b where they overlap, < 0 behind, 0: neither. */
static double in_front(const km_item *a, const km_item *b) {
  double result = 0.0;
  if (a->kind >= KM_ITEM_ROD && b->kind >= KM_ITEM_ROD && a->joint == b->joint)
    return (double)a->kind - (double)b->kind; /* the rod comes out of the cylinder */
  for (int i = 0; i < edges(a); ++i)
    for (int k = 0; k < edges(b); ++k) {
      km_spot p[2], q[2];
      edge(a, i, p);
      edge(b, k, q);
      meeting m = meet(p, q);
      if (m.distance <= a->reach + b->reach && fabs(m.depth) > fabs(result))
        result = m.depth;
    }
  return fabs(result) > 1e-6 ? result : 0.0;
}

static int by_depth(const void *x, const void *y) {
  const km_item *a = x, *b = y;
  if (a->layer != b->layer)
    return a->layer - b->layer;
  if (a->depth != b->depth)
    return a->depth < b->depth ? -1 : 1;
  if (a->kind != b->kind)
    return (int)a->kind - (int)b->kind;
  return a->body != b->body ? a->body - b->body : a->joint - b->joint;
}

/* Takes again and again the farthest item with nothing left behind it; where items hide each other
 * in a ring, simply the farthest. */
static void copy_in_order(km_scene *scene, km_item *ordered, int *behind, const signed char *front) {
  size_t n = scene->count;
  for (size_t taken = 0; taken < n; ++taken) {
    size_t choice = n;
    for (size_t i = 0; i < n; ++i) /* they are sorted by depth */
      if (behind[i] >= 0 && (choice == n || (behind[i] == 0 && behind[choice] > 0)))
        choice = i;
    ordered[taken] = scene->items[choice];
    behind[choice] = -1;
    for (size_t i = 0; i < n; ++i)
      if (behind[i] > 0 && front[i * n + choice] > 0)
        --behind[i];
  }
}

void km_scene_order(km_scene *scene) {
  size_t n = scene->count;
  qsort(scene->items, n, sizeof *scene->items, by_depth);
  if (scene->view->planar || n > MOST_COMPARED)
    return;
  km_item *ordered = KM_ARENA_NEW(scene->arena, km_item, n);
  int *behind = KM_ARENA_NEW(scene->arena, int, n);                   /* number of items that must be painted before */
  signed char *front = KM_ARENA_NEW(scene->arena, signed char, n *n); /* [i, k] i in front of k */
  if (scene->arena->failed)
    return;
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < i; ++k) {
      const km_item *a = &scene->items[i], *b = &scene->items[k];
      double order = a->layer != b->layer ? a->layer - b->layer : in_front(a, b);
      size_t later = order > 0.0 ? i : k, earlier = order > 0.0 ? k : i;
      if (order == 0.0)
        continue;
      front[later * n + earlier] = 1;
      behind[later]++;
    }
  copy_in_order(scene, ordered, behind, front);
  scene->items = ordered;
}
