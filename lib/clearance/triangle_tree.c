/* Nearest triangle by a tree of bounding boxes: a range of the sorted triangles is halved by the middles of its
 * triangles along the longest side of its box. A branch whose box is farther than the nearest triangle so far is
 * skipped. */
#include "clearance/triangle_tree.h"

#include <math.h>
#include <stdlib.h>

enum { LEAF = 4 };

typedef struct box {
  double low[3], high[3];
} box;

typedef struct leaf_triangle {
  int index;
  double middle[3], key;
} leaf_triangle;

struct km_triangle_tree {
  const km_mesh *mesh;
  leaf_triangle *triangles; /* [triangle count] in the order of the tree */
  box *boxes;               /* node k has the children 2 k + 1 and 2 k + 2 */
};

static const km_vec3 *corner(const km_mesh *mesh, int triangle, int k) {
  return &mesh->vertices[mesh->triangles[triangle].corner[k]];
}

static double to_segment(km_vec3 x, km_vec3 a, km_vec3 b) {
  km_vec3 e = km_vec3_sub(b, a), d = km_vec3_sub(x, a);
  double square = km_vec3_dot(e, e), t = square > 0.0 ? km_vec3_dot(d, e) / square : 0.0;
  return km_vec3_norm(km_vec3_axpy(-fmin(1.0, fmax(0.0, t)), e, d));
}

/* The distance from the plane where the point projects into the triangle, else from an edge. */
double km_triangle_distance(const km_mesh *mesh, int triangle, km_vec3 x) {
  const km_vec3 a = *corner(mesh, triangle, 0), b = *corner(mesh, triangle, 1), c = *corner(mesh, triangle, 2);
  const km_vec3 e = km_vec3_sub(b, a), g = km_vec3_sub(c, a), n = km_vec3_cross(e, g), d = km_vec3_sub(x, a);
  double square = km_vec3_dot(n, n), u = km_vec3_dot(km_vec3_cross(d, g), n), v = km_vec3_dot(km_vec3_cross(e, d), n);
  if (u >= 0.0 && v >= 0.0 && u + v <= square && square > 0.0)
    return fabs(km_vec3_dot(d, n)) / sqrt(square);
  return fmin(to_segment(x, a, b), fmin(to_segment(x, b, c), to_segment(x, c, a)));
}

static int by_key(const void *a, const void *b) {
  const leaf_triangle *x = a, *y = b;
  return x->key != y->key ? (x->key < y->key ? -1 : 1) : x->index - y->index;
}

static box box_of(const km_triangle_tree *t, int first, int count) {
  box out = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
  for (int i = 0; i < 3 * count; ++i) {
    const km_vec3 *p = corner(t->mesh, t->triangles[first + i / 3].index, i % 3);
    const double x[3] = {p->x, p->y, p->z};
    for (int k = 0; k < 3; ++k) {
      out.low[k] = fmin(out.low[k], x[k]);
      out.high[k] = fmax(out.high[k], x[k]);
    }
  }
  return out;
}

static void build(const km_triangle_tree *t, size_t node, int first, int count) {
  t->boxes[node] = box_of(t, first, count);
  if (count <= LEAF)
    return;
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (t->boxes[node].high[k] - t->boxes[node].low[k] > t->boxes[node].high[axis] - t->boxes[node].low[axis])
      axis = k;
  for (int i = first; i < first + count; ++i)
    t->triangles[i].key = t->triangles[i].middle[axis];
  qsort(t->triangles + first, (size_t)count, sizeof *t->triangles, by_key);
  build(t, 2 * node + 1, first, count / 2);
  build(t, 2 * node + 2, first + count / 2, count - count / 2);
}

const km_triangle_tree *km_triangle_tree_create(const km_mesh *mesh, km_arena *arena) {
  size_t nodes = 2;
  for (int left = mesh->triangle_count; left > LEAF; left -= left / 2) /* halves, rounded up, as the larger branch */
    nodes *= 2;
  km_triangle_tree *t = KM_ARENA_NEW(arena, km_triangle_tree, 1);
  if (!t || mesh->triangle_count == 0)
    return NULL;
  t->mesh = mesh;
  t->triangles = KM_ARENA_NEW(arena, leaf_triangle, (size_t)mesh->triangle_count);
  t->boxes = KM_ARENA_NEW(arena, box, nodes);
  if (!t->triangles || !t->boxes)
    return NULL;
  for (int i = 0; i < mesh->triangle_count; ++i) {
    t->triangles[i].index = i;
    for (int k = 0; k < 3; ++k) {
      const km_vec3 *p = corner(mesh, i, k);
      t->triangles[i].middle[0] += p->x / 3.0;
      t->triangles[i].middle[1] += p->y / 3.0;
      t->triangles[i].middle[2] += p->z / 3.0;
    }
  }
  build(t, 0, 0, mesh->triangle_count);
  return t;
}

static double to_box(const box *b, km_vec3 p) {
  const double x[3] = {p.x, p.y, p.z};
  double square = 0.0;
  for (int k = 0; k < 3; ++k) {
    double off = fmax(0.0, fmax(b->low[k] - x[k], x[k] - b->high[k]));
    square += off * off;
  }
  return sqrt(square);
}

static void search(const km_triangle_tree *t, size_t node, int first, int count, km_vec3 p, int *nearest,
                   double *distance) {
  if (count <= LEAF) {
    for (int i = first; i < first + count; ++i) {
      double d = km_triangle_distance(t->mesh, t->triangles[i].index, p);
      *nearest = d < *distance ? t->triangles[i].index : *nearest;
      *distance = fmin(d, *distance);
    }
    return;
  }
  double left = to_box(&t->boxes[2 * node + 1], p), right = to_box(&t->boxes[2 * node + 2], p);
  for (int k = 0; k < 2; ++k) { /* the nearer branch first */
    bool is_left = (left <= right) == (k == 0);
    if ((is_left ? left : right) < *distance)
      search(t, 2 * node + (is_left ? 1 : 2), is_left ? first : first + count / 2,
             is_left ? count / 2 : count - count / 2, p, nearest, distance);
  }
}

int km_triangle_tree_nearest(const km_triangle_tree *t, km_vec3 point, double *distance) {
  int nearest = -1;
  *distance = HUGE_VAL;
  search(t, 0, 0, t->mesh->triangle_count, point, &nearest, distance);
  return nearest;
}
