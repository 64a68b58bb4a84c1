/* Visibility order of faces by a binary space partition (H. Fuchs, Z. Kedem, B. Naylor, On visible surface
 * generation by a priori tree structures, 1980), traversed while it is built, because the viewer is fixed. Faces
 * that the plane of another face cuts are split, so intersecting faces are correct, too. */
#include "report/drawing/drawing_parts.h"

#include <stdlib.h>

static const double level = 1e-4; /* points: nearer to a plane is on it */
enum { CANDIDATES = 6, MOST_CUT = 30 /* corners; shown edges are bits */ };

typedef struct plane {
  km_spot normal;
  double offset;
} plane;

static double above(const plane *p, km_spot at) {
  return p->normal.x * at.x + p->normal.y * at.y + p->normal.depth * at.depth - p->offset;
}

static plane plane_of(const km_face *face) {
  plane p = {face->normal, 0.0};
  p.offset = above(&p, face->spots[0]);
  return p;
}

typedef enum place { PLACE_LEVEL, PLACE_FRONT, PLACE_BEHIND, PLACE_BOTH } place;

static place place_of(const plane *p, const km_face *face) {
  bool front = false, behind = false;
  for (int i = 0; i < face->count; ++i) {
    double height = above(p, face->spots[i]);
    front = front || height > level;
    behind = behind || height < -level;
  }
  return front && behind ? PLACE_BOTH : front ? PLACE_FRONT : behind ? PLACE_BEHIND : PLACE_LEVEL;
}

static void add_corner(km_face *face, km_spot at, bool shown) {
  face->shown |= (unsigned)shown << face->count;
  face->spots[face->count++] = at;
}

/* The part of a face on one side (+1 or -1) of a plane that cuts it. */
static km_face *cut(const plane *p, const km_face *face, double side, km_arena *arena) {
  km_face *part = KM_ARENA_NEW(arena, km_face, 1);
  km_spot *spots = KM_ARENA_NEW(arena, km_spot, (size_t)face->count + 2);
  if (!part || !spots)
    return NULL;
  *part = *face;
  part->spots = spots;
  part->count = 0;
  part->shown = 0;
  for (int i = 0; i < face->count; ++i) {
    km_spot a = face->spots[i], b = face->spots[(i + 1) % face->count];
    bool shown = face->shown >> i & 1U;
    double from = side * above(p, a), to = side * above(p, b);
    if (from >= 0.0)
      add_corner(part, a, shown && !(from == 0.0 && to < 0.0));
    if ((from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0)) {
      double t = from / (from - to);
      /* Entering, the rest of the edge shows; leaving, the cut begins. */
      add_corner(part, (km_spot){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.depth + t * (b.depth - a.depth)},
                 shown && to > 0.0);
    }
  }
  return part;
}

/* Chooses among a few faces the one whose plane splits the fewest others and balances the sides. */
static km_face *choose(km_face *list, int count) {
  km_face *best = list;
  int least = -1, stride = count / CANDIDATES + 1, i = 0;
  for (km_face *f = list; f; f = f->next) {
    if (i++ % stride)
      continue;
    plane p = plane_of(f);
    int sides[4] = {0};
    for (const km_face *other = list; other; other = other->next)
      sides[place_of(&p, other)]++;
    int cost = 8 * sides[PLACE_BOTH] + abs(sides[PLACE_FRONT] - sides[PLACE_BEHIND]);
    if (least < 0 || cost < least) {
      least = cost;
      best = f;
    }
  }
  return best;
}

/* Faces yet to be ordered; what is on top of the stack is nearest to the viewer. */
typedef struct heap {
  km_face *list;
  bool ordered;
  struct heap *next;
} heap;

static heap *push(heap *stack, km_face *list, bool ordered, km_arena *arena) {
  heap *top = list ? KM_ARENA_NEW(arena, heap, 1) : NULL;
  if (!top)
    return stack;
  *top = (heap){list, ordered, stack};
  return top;
}

static void prepend(km_face **list, km_face *face) {
  if (!face)
    return;
  face->next = *list;
  *list = face;
}

static heap *divide(heap *stack, km_face *list, km_arena *arena) {
  int count = 0;
  for (const km_face *f = list; f; f = f->next)
    ++count;
  plane p = plane_of(choose(list, count));
  km_face *sides[4] = {NULL};
  for (km_face *f = list, *next; f; f = next) {
    next = f->next;
    place where = place_of(&p, f);
    if (where == PLACE_BOTH && f->count < MOST_CUT) {
      prepend(&sides[PLACE_FRONT], cut(&p, f, 1.0, arena));
      prepend(&sides[PLACE_BEHIND], cut(&p, f, -1.0, arena));
    } else {
      prepend(&sides[where == PLACE_BOTH ? PLACE_FRONT : where], f);
    }
  }
  stack = push(stack, sides[PLACE_BEHIND], false, arena);
  stack = push(stack, sides[PLACE_LEVEL], true, arena);
  return push(stack, sides[PLACE_FRONT], false, arena);
}

km_face *km_faces_order(km_face *faces, km_arena *arena) {
  km_face *ordered = NULL;
  heap *stack = push(NULL, faces, false, arena);
  while (stack && !arena->failed) {
    heap top = *stack;
    stack = top.next;
    if (!top.ordered) {
      stack = divide(stack, top.list, arena);
      continue;
    }
    for (km_face *f = top.list, *next; f; f = next) {
      next = f->next;
      prepend(&ordered, f);
    }
  }
  return ordered;
}
