/* Depth of the overlap of two convex cores by an expanding polytope (G. van den Bergen, Proximity queries and
 * penetration depth computation on 3D game objects, 2001).
 *
 *   M          difference of the cores, support function h;  depth = min over unit n of h(n)
 *   polytope   hull of support points of M; its face nearest to the origin at n · x = f:  f ≤ depth ≤ h(n)
 *
 * That face is replaced by faces to the support point in its direction until h(n) − f is rounding. The distance f of a
 * face has a sign, so that the first polytope need not contain the origin. */
#include "clearance/convex.h"

#include <float.h>
#include <stdbool.h>

enum { MOST_POINTS = 320, MOST_FACES = 2 * MOST_POINTS };
/* h(n) − f at which the search ends, and height above a face at which a point sees it, in units of the size. */
static const double gap_end = 16.0 * DBL_EPSILON, visible = 2.0 * DBL_EPSILON;
/* Extent below which the difference is flat, in units of its size: rounding of coordinates. */
static const double flat = 1e-13;
/* Difference of the normals of coplanar faces. */
static const double coplanar = 1e-10;

/* Sine of the angle at a corner below which a face has no area: rounding of points decides its normal. */
static const double thin = 1e-12;

typedef struct face {
  int corner[3]; /* counter-clockwise seen from outside */
  km_vec3 normal;
  double distance; /* f; infinite for a face without area, or out of the search */
  bool is_seen;    /* seen from the new point */
} face;

typedef struct polytope {
  const km_convex_pair *pair;
  double size;
  int point_count, face_count;
  km_difference_point points[MOST_POINTS];
  face faces[MOST_FACES];
  int edges[MOST_FACES][2];
} polytope;

static km_vec3 unit(km_vec3 v) {
  double length = km_vec3_norm(v);
  return km_vec3_scale(length > 0.0 ? 1.0 / length : 0.0, v);
}

static bool add_face(polytope *m, int a, int b, int c) {
  if (m->face_count == MOST_FACES)
    return false;
  km_vec3 p = m->points[a].w;
  km_vec3 e = km_vec3_sub(m->points[b].w, p), g = km_vec3_sub(m->points[c].w, p), n = km_vec3_cross(e, g);
  bool has_area = km_vec3_norm(n) > thin * km_vec3_norm(e) * km_vec3_norm(g);
  n = unit(n);
  m->faces[m->face_count++] = (face){{a, b, c}, n, has_area ? km_vec3_dot(n, p) : HUGE_VAL, false};
  return true;
}

/* Farther one of the two support points along ±d, by its height over the point p. */
static km_difference_point farther(const polytope *m, km_vec3 d, km_vec3 p, double *height) {
  km_difference_point up = km_difference_support(m->pair, d),
                      down = km_difference_support(m->pair, km_vec3_scale(-1.0, d));
  double above = km_vec3_dot(d, km_vec3_sub(up.w, p)), below = km_vec3_dot(d, km_vec3_sub(p, down.w));
  *height = fmax(above, below);
  return above >= below ? up : down;
}

/* First two points: the largest extent along the axes. Returns it. */
static double begin_line(polytope *m) {
  static const km_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double most = -1.0;
  for (int k = 0; k < 3; ++k) {
    km_difference_point high = km_difference_support(m->pair, axes[k]),
                        low = km_difference_support(m->pair, km_vec3_scale(-1.0, axes[k]));
    double extent = km_vec3_dot(axes[k], km_vec3_sub(high.w, low.w));
    if (extent > most) {
      most = extent;
      m->points[0] = low;
      m->points[1] = high;
    }
  }
  return most;
}

/* Makes a tetrahedron of support points. False: the difference is flat; `*normal` is then normal to it. */
static bool begin(polytope *m, km_vec3 *normal) {
  double height[2], least = flat * m->size;
  *normal = (km_vec3){1, 0, 0};
  if (!(begin_line(m) > least))
    return false;
  km_vec3 p = m->points[0].w, line = unit(km_vec3_sub(m->points[1].w, p)), side = km_vec3_perpendicular(line);
  km_difference_point a = farther(m, side, p, &height[0]), b = farther(m, km_vec3_cross(line, side), p, &height[1]);
  *normal = side;
  if (!(fmax(height[0], height[1]) > least))
    return false;
  m->points[2] = height[0] >= height[1] ? a : b;
  *normal = unit(km_vec3_cross(line, km_vec3_sub(m->points[2].w, p)));
  m->points[3] = farther(m, *normal, p, &height[0]);
  if (!(height[0] > least))
    return false;
  bool above = km_vec3_dot(*normal, km_vec3_sub(m->points[3].w, p)) > 0.0;
  int one = above ? 2 : 1, two = above ? 1 : 2;
  m->point_count = 4;
  return add_face(m, 0, one, two) && add_face(m, 0, two, 3) && add_face(m, two, one, 3) && add_face(m, one, 0, 3);
}

static int nearest_face(const polytope *m) {
  int nearest = 0;
  for (int i = 1; i < m->face_count; ++i)
    nearest = m->faces[i].distance < m->faces[nearest].distance ? i : nearest;
  return nearest;
}

/* Adds an edge of a removed face, or removes it if its reverse is there: what remains is the horizon. */
static int toggle_edge(polytope *m, int count, int a, int b) {
  for (int i = 0; i < count; ++i)
    if (m->edges[i][0] == b && m->edges[i][1] == a) {
      m->edges[i][0] = m->edges[count - 1][0];
      m->edges[i][1] = m->edges[count - 1][1];
      return count - 1;
    }
  m->edges[count][0] = a;
  m->edges[count][1] = b;
  return count + 1;
}

static bool has_corner(const polytope *m, km_vec3 w) {
  for (int i = 0; i < m->point_count; ++i)
    if (m->points[i].w.x == w.x && m->points[i].w.y == w.y && m->points[i].w.z == w.z)
      return true;
  return false;
}

/* True if each vertex of the horizon begins one edge. */
static bool is_one_loop(const polytope *m, int count) {
  int at = count > 2 ? m->edges[0][1] : -1, seen = 1;
  while (at >= 0 && at != m->edges[0][0] && seen < count) {
    int next = -1;
    for (int i = 0; i < count; ++i)
      next = m->edges[i][0] == at ? m->edges[i][1] : next;
    at = next;
    ++seen;
  }
  return count > 2 && at == m->edges[0][0] && seen == count;
}

/* Finds the faces that the point sees, and their horizon. Returns the number of its edges; 0: rounding has made the
 * faces no disc, or there are too many edges. */
static int find_horizon(polytope *m, const km_difference_point *p) {
  int edges = 0;
  for (int i = 0; i < m->face_count; ++i) {
    face *f = &m->faces[i];
    f->is_seen = km_vec3_dot(f->normal, km_vec3_sub(p->w, m->points[f->corner[0]].w)) > visible * m->size;
    for (int k = 0; k < 3 && f->is_seen; ++k) {
      if (edges == MOST_FACES)
        return 0;
      edges = toggle_edge(m, edges, f->corner[k], f->corner[(k + 1) % 3]);
    }
  }
  return is_one_loop(m, edges) ? edges : 0;
}

/* Replaces the faces that the point sees. False at the limits of memory. A face is left out of the search if its point
 * is a corner already: rounding has turned its normal. */
static bool expand(polytope *m, int nearest, const km_difference_point *p) {
  int edges = has_corner(m, p->w) ? 0 : find_horizon(m, p), kept = 0;
  if (edges == 0) {
    m->faces[nearest].distance = HUGE_VAL;
    return true;
  }
  if (m->point_count == MOST_POINTS)
    return false;
  for (int i = 0; i < m->face_count; ++i)
    if (!m->faces[i].is_seen)
      m->faces[kept++] = m->faces[i];
  m->face_count = kept;
  m->points[m->point_count++] = *p;
  for (int i = 0; i < edges; ++i)
    if (!add_face(m, m->edges[i][0], m->edges[i][1], m->point_count - 1))
      return false;
  return true;
}

/* Weights of the projection of the origin to a face's plane. */
static void weights_of(const polytope *m, const face *f, double weight[3]) {
  const km_vec3 p = m->points[f->corner[0]].w, o = km_vec3_scale(-1.0, p);
  const km_vec3 e = km_vec3_sub(m->points[f->corner[1]].w, p), g = km_vec3_sub(m->points[f->corner[2]].w, p);
  double area = km_vec3_norm(km_vec3_cross(e, g));
  weight[1] = km_vec3_dot(km_vec3_cross(o, g), f->normal) / area;
  weight[2] = km_vec3_dot(km_vec3_cross(e, o), f->normal) / area;
  weight[0] = 1.0 - weight[1] - weight[2];
}

/* Points of the cores at the projection of the origin to a face's plane. The coplanar face that contains the
 * projection best counts. */
static void write_points(const polytope *m, const face *of, km_convex_distance *out) {
  double inside = -HUGE_VAL;
  for (int i = 0; i < m->face_count; ++i) {
    const face *f = &m->faces[i];
    km_vec3 turn = km_vec3_sub(f->normal, of->normal);
    double weight[3];
    if (!(fabs(f->distance - of->distance) <= gap_end * m->size && km_vec3_norm(turn) <= coplanar))
      continue;
    weights_of(m, f, weight);
    double smallest = fmin(weight[0], fmin(weight[1], weight[2]));
    if (!(smallest > inside))
      continue;
    inside = smallest;
    out->a = out->b = (km_vec3){0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      out->a = km_vec3_axpy(weight[k], m->points[f->corner[k]].a, out->a);
      out->b = km_vec3_axpy(weight[k], m->points[f->corner[k]].b, out->b);
    }
  }
  out->normal = of->normal;
}

static void take_flat(const polytope *m, km_vec3 normal, km_convex_distance *out) {
  km_vec3 back = km_vec3_scale(-1.0, normal);
  double up = km_vec3_dot(normal, km_difference_support(m->pair, normal).w),
         down = km_vec3_dot(back, km_difference_support(m->pair, back).w);
  out->normal = up <= down ? normal : back;
  out->error += fabs(fmin(up, down));
}

void km_convex_depth_compute(const km_convex_pair *pair, double scale, km_convex_distance *out) {
  polytope m;
  km_vec3 normal;
  m.pair = pair;
  m.size = scale;
  m.point_count = m.face_count = 0;
  if (!begin(&m, &normal)) {
    take_flat(&m, normal, out);
    return;
  }
  double upper = HUGE_VAL, lower = -HUGE_VAL, written = -HUGE_VAL;
  for (bool grows = true; grows;) {
    int nearest = nearest_face(&m);
    const face f = m.faces[nearest];
    if (!(f.distance < HUGE_VAL))
      break;
    km_difference_point p = km_difference_support(pair, f.normal);
    double h = km_vec3_dot(f.normal, p.w);
    lower = fmax(lower, f.distance);
    if (h < upper - gap_end * scale || (h <= upper + gap_end * scale && f.distance > written)) {
      write_points(&m, &f, out);
      written = f.distance;
    }
    upper = fmin(upper, h);
    grows = h - f.distance > gap_end * scale && expand(&m, nearest, &p);
  }
  if (!(upper < HUGE_VAL)) { /* every face of the first tetrahedron is thin */
    take_flat(&m, normal, out);
    return;
  }
  if (upper > 0.0 || out->distance == 0.0)
    out->distance = -upper;
  out->error = fmax(0.0, upper - lower) + gap_end * scale;
  /* Moves the points onto the planes across the normal: a search that ends early leaves them beside. */
  double miss = 0.5 * (km_vec3_dot(out->normal, km_vec3_sub(out->b, out->a)) - out->distance);
  out->a = km_vec3_axpy(miss, out->normal, out->a);
  out->b = km_vec3_axpy(-miss, out->normal, out->b);
}
