/* Convex hulls by quickhull in integers. */
#include "model/geometry/hull.h"

#include "base/memory.h"

#include <math.h>
#include <stdint.h>

/* Coordinates on a grid of 2^30 steps: a normal then has less than 62 bits, and a distance times it less than 94. */
__extension__ typedef __int128 wide;

typedef struct point {
  int64_t x[3];
} point;

typedef struct face {
  int corner[3], beyond[3]; /* adjacent faces: beyond[k] across the edge from corner k to the next corner */
  point normal;
  int outside, farthest; /* list (by `next`) of points outside the face; -1: none */
  wide height;           /* distance of the farthest one */
  bool seen, gone;
} face;

typedef struct side {
  int from, to, face, index; /* the hidden face across the edge, and the index of this edge in it */
} side;

typedef struct hull {
  km_arena arena;
  int count;     /* number of points */
  point *points; /* [count] */
  int *next;     /* [count] next point in the list of a face */
  int *starting; /* [count] new face whose horizon edge starts at a point */
  face *faces;
  int face_count, free_face; /* deleted faces, a list by `outside` */
  size_t face_room, work_room, horizon_room, seen_room;
  int *work; /* faces that may have points outside */
  int work_count;
  side *horizon;
  int horizon_count;
  int *seen;
  int seen_count;
} hull;

static point difference(const hull *h, int a, int b) {
  point d;
  for (int k = 0; k < 3; ++k)
    d.x[k] = h->points[a].x[k] - h->points[b].x[k];
  return d;
}

static point cross(const point *a, const point *b) {
  return (point){{a->x[1] * b->x[2] - a->x[2] * b->x[1], a->x[2] * b->x[0] - a->x[0] * b->x[2],
                  a->x[0] * b->x[1] - a->x[1] * b->x[0]}};
}

static wide dot(const point *a, const point *b) {
  return (wide)a->x[0] * b->x[0] + (wide)a->x[1] * b->x[1] + (wide)a->x[2] * b->x[2];
}

static point normal_of(const hull *h, int a, int b, int c) {
  point u = difference(h, b, a), v = difference(h, c, a);
  return cross(&u, &v);
}

/* Positive if the point lies outside the face. */
static wide height_over(const hull *h, const face *f, int p) {
  point d = difference(h, p, f->corner[0]);
  return dot(&f->normal, &d);
}

/* Index of a new face; -1 when out of memory. */
static int add_face(hull *h, int a, int b, int c) {
  int index = h->free_face;
  if (index >= 0) {
    h->free_face = h->faces[index].outside;
  } else {
    index = h->face_count;
    if (!km_arena_grow(&h->arena, (void **)&h->faces, &h->face_room, (size_t)index + 1, sizeof *h->faces))
      return -1;
    h->face_count++;
  }
  h->faces[index] = (face){.corner = {a, b, c}, .normal = normal_of(h, a, b, c), .outside = -1, .farthest = -1};
  return index;
}

/* Assigns a point to the first face that it lies outside of. */
static void give(hull *h, int p, const int *faces, int count) {
  for (int i = 0; i < count; ++i) {
    face *f = &h->faces[faces[i]];
    wide height = height_over(h, f, p);
    if (height <= 0)
      continue;
    h->next[p] = f->outside;
    f->outside = p;
    if (height > f->height) {
      f->height = height;
      f->farthest = p;
    }
    return;
  }
}

static bool push(hull *h, int **list, int *count, size_t *room, int value) {
  if (!km_arena_grow(&h->arena, (void **)list, room, (size_t)*count + 1, sizeof **list))
    return false;
  (*list)[(*count)++] = value;
  return true;
}

static bool queue(hull *h, int index) {
  return h->faces[index].outside < 0 || push(h, &h->work, &h->work_count, &h->work_room, index);
}

/* The point with the largest |measure|; the measure is 0 if there is none. */
typedef double (*measure)(const hull *h, const int *fixed, int p);

static double from_one(const hull *h, const int *fixed, int p) {
  point d = difference(h, p, fixed[0]);
  return (double)dot(&d, &d);
}

static double from_line(const hull *h, const int *fixed, int p) {
  point n = normal_of(h, fixed[0], fixed[1], p);
  double sum = 0.0;
  for (int k = 0; k < 3; ++k)
    sum += (double)n.x[k] * (double)n.x[k];
  return sum;
}

static double from_plane(const hull *h, const int *fixed, int p) {
  point n = normal_of(h, fixed[0], fixed[1], fixed[2]), d = difference(h, p, fixed[0]);
  return (double)dot(&n, &d);
}

static int find_farthest(const hull *h, measure value, const int *fixed) {
  int best = -1;
  double most = 0.0;
  for (int p = 0; p < h->count; ++p)
    if (fabs(value(h, fixed, p)) > most) {
      most = fabs(value(h, fixed, p));
      best = p;
    }
  return best;
}

/* Creates the initial tetrahedron. False if all points are coplanar, or when out of memory. */
static bool begin(hull *h) {
  static const int corners[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  static const int beyond[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  static const measure steps[3] = {from_one, from_line, from_plane};
  int v[4] = {0}, faces[4];
  for (int k = 0; k < 3; ++k)
    if ((v[k + 1] = find_farthest(h, steps[k], v)) < 0)
      return false;
  if (from_plane(h, v, v[3]) > 0.0) { /* the first face must be oriented away from the fourth point */
    int keep = v[1];
    v[1] = v[2];
    v[2] = keep;
  }
  for (int f = 0; f < 4; ++f)
    if ((faces[f] = add_face(h, v[corners[f][0]], v[corners[f][1]], v[corners[f][2]])) < 0)
      return false;
  for (int f = 0; f < 4; ++f)
    for (int k = 0; k < 3; ++k)
      h->faces[faces[f]].beyond[k] = faces[beyond[f][k]];
  for (int p = 0; p < h->count; ++p)
    give(h, p, faces, 4);
  for (int f = 0; f < 4; ++f)
    if (!queue(h, faces[f]))
      return false;
  return true;
}

/* Collects all faces visible from a point, starting from one of them, and the horizon edges around them. */
static bool inspect(hull *h, int first, int p) {
  h->seen_count = h->horizon_count = 0;
  h->faces[first].seen = true;
  if (!push(h, &h->seen, &h->seen_count, &h->seen_room, first))
    return false;
  for (int i = 0; i < h->seen_count; ++i)
    for (int k = 0; k < 3; ++k) {
      const face *f = &h->faces[h->seen[i]];
      int other = f->beyond[k], from = f->corner[k], to = f->corner[(k + 1) % 3];
      face *g = &h->faces[other];
      if (g->seen)
        continue;
      if (height_over(h, g, p) > 0) {
        g->seen = true;
        if (!push(h, &h->seen, &h->seen_count, &h->seen_room, other))
          return false;
        continue;
      }
      int index = g->corner[0] == to ? 0 : g->corner[1] == to ? 1 : 2;
      if (!km_arena_grow(&h->arena, (void **)&h->horizon, &h->horizon_room, (size_t)h->horizon_count + 1,
                         sizeof *h->horizon))
        return false;
      h->horizon[h->horizon_count++] = (side){from, to, other, index};
    }
  return true;
}

/* Creates a cone of new faces from the point to the horizon, into `fresh`. */
static bool close_up(hull *h, int p, int *fresh) {
  for (int i = 0; i < h->horizon_count; ++i) {
    const side *s = &h->horizon[i];
    int index = add_face(h, s->from, s->to, p);
    if (index < 0)
      return false;
    h->faces[index].beyond[0] = s->face;
    h->faces[s->face].beyond[s->index] = index;
    h->starting[s->from] = index;
    fresh[i] = index;
  }
  for (int i = 0; i < h->horizon_count; ++i) {
    int after = h->starting[h->horizon[i].to];
    h->faces[fresh[i]].beyond[1] = after;
    h->faces[after].beyond[2] = fresh[i];
  }
  return true;
}

/* Reassigns the points of visible faces to new faces, or drops them as interior points. */
static bool release(hull *h, int p, const int *fresh, int count) {
  for (int i = 0; i < h->seen_count; ++i) {
    face *f = &h->faces[h->seen[i]];
    for (int q = f->outside, after; q >= 0; q = after) {
      after = h->next[q];
      if (q != p)
        give(h, q, fresh, count);
    }
    f->gone = true;
    f->outside = h->free_face;
    h->free_face = h->seen[i];
  }
  for (int i = 0; i < count; ++i)
    if (!queue(h, fresh[i]))
      return false;
  return true;
}

static bool grow(hull *h) {
  int *fresh = NULL;
  size_t room = 0;
  while (h->work_count > 0) {
    int index = h->work[--h->work_count];
    if (h->faces[index].gone || h->faces[index].outside < 0)
      continue;
    int p = h->faces[index].farthest;
    if (!inspect(h, index, p) ||
        !km_arena_grow(&h->arena, (void **)&fresh, &room, (size_t)h->horizon_count, sizeof *fresh) ||
        !close_up(h, p, fresh) || !release(h, p, fresh, h->horizon_count))
      return false;
  }
  return true;
}

static void set_grid(hull *h, const km_mesh *mesh) {
  km_vec3 low, high;
  km_mesh_box(mesh, &low, &high);
  double size = fmax(high.x - low.x, fmax(high.y - low.y, high.z - low.z)), steps = 1 << 30;
  for (int i = 0; i < h->count && size > 0.0; ++i) {
    km_vec3 d = km_vec3_sub(mesh->vertices[i], low);
    const double x[3] = {d.x, d.y, d.z};
    for (int k = 0; k < 3; ++k)
      h->points[i].x[k] = llround(steps * (x[k] / size));
  }
}

static km_mesh *copy_out(hull *h, const km_mesh *mesh) {
  int *number = h->next, vertices = 0, triangles = 0;
  for (int i = 0; i < h->count; ++i)
    number[i] = -1;
  for (int f = 0; f < h->face_count; ++f)
    for (int k = 0; k < 3 && !h->faces[f].gone; ++k) {
      int *n = &number[h->faces[f].corner[k]];
      *n = *n < 0 ? vertices++ : *n;
      triangles += k == 0;
    }
  km_mesh *out = km_mesh_create(vertices, triangles);
  for (int i = 0; i < h->count && out; ++i)
    if (number[i] >= 0)
      out->vertices[number[i]] = mesh->vertices[i];
  for (int f = 0, t = 0; f < h->face_count && out; ++f) {
    const face *s = &h->faces[f];
    if (!s->gone)
      out->triangles[t++] = (km_triangle){.corner = {number[s->corner[0]], number[s->corner[1]], number[s->corner[2]]}};
  }
  return out;
}

km_status km_mesh_hull(const km_mesh *mesh, km_mesh **out, km_error *error) {
  hull h = {.count = mesh->vertex_count, .free_face = -1};
  size_t room = (size_t)h.count;
  *out = NULL;
  h.points = KM_ARENA_NEW(&h.arena, point, room);
  h.next = KM_ARENA_NEW(&h.arena, int, room);
  h.starting = KM_ARENA_NEW(&h.arena, int, room);
  bool solid = false;
  if (!h.arena.failed) {
    set_grid(&h, mesh);
    solid = begin(&h);
    if (solid && grow(&h))
      *out = copy_out(&h, mesh);
  }
  km_status status = KM_OK;
  if (!*out && !h.arena.failed && !solid)
    status = km_fail(error, KM_MODEL, "all %d points lie in a plane; expected a body", h.count);
  else if (!*out)
    status = km_fail(error, KM_MEMORY, "out of memory for a convex hull");
  km_arena_free(&h.arena);
  return status;
}
