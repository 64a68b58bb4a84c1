/* Distance of two convex parts by the method of E. G. Gilbert, D. W. Johnson and S. S. Keerthi (A fast procedure for
 * computing the distance between complex objects in three-dimensional space, 1988).
 *
 *   v      point of a simplex of points w = a − b that is nearest to the origin
 *   w      support point in the direction −v:  v·w/|v| ≤ distance of the cores ≤ |v|
 *   gap    |v| minus the largest lower bound, whose direction is the normal; polyhedra reach rounding in finitely many
 *          steps
 *
 * The nearest point of a simplex is the nearest one among the projections of the origin to its vertices, edges and
 * faces that lie within them. Where the cores touch or overlap, the depth decides (convex_depth.c). */
#include "clearance/convex.h"

#include <float.h>
#include <stdbool.h>

enum { MOST_STEPS = 200 };
/* Gap in units of the size of the difference: rounding of v·w/|v|. */
static const double gap_rounding = 8.0 * DBL_EPSILON;
/* Below this part of the size, the direction of v has lost half of its digits. */
static const double touching = 1e-8;
/* Sine of the angle at which an edge, a face or a corner of a simplex counts as degenerate. */
static const double degenerate = 1e-13;

typedef struct simplex {
  int count;
  km_difference_point p[4];
  double weight[4]; /* λ of the nearest point, Σ λ = 1 */
} simplex;

km_vec3 km_convex_support(const km_convex *part, km_vec3 d) {
  int best = 0;
  double most = km_vec3_dot(part->points[0], d);
  for (int i = 1; i < part->count; ++i) {
    double h = km_vec3_dot(part->points[i], d);
    best = h > most ? i : best;
    most = h > most ? h : most;
  }
  km_vec3 across = km_vec3_axpy(-km_vec3_dot(part->axis, d), part->axis, d);
  double length = part->disc > 0.0 ? km_vec3_norm(across) : 0.0;
  return length > 0.0 ? km_vec3_axpy(part->disc / length, across, part->points[best]) : part->points[best];
}

km_difference_point km_difference_support(const km_convex_pair *pair, km_vec3 d) {
  km_difference_point p;
  p.a = km_convex_support(pair->part[0], d);
  p.b = km_convex_support(pair->part[1], km_rotate_back(&pair->pose.R, km_vec3_scale(-1.0, d)));
  p.b = km_pose_point(&pair->pose, p.b);
  p.w = km_vec3_sub(p.a, p.b);
  return p;
}

/* Weights of the projection of the origin to the line, plane or space through `count` points; false if degenerate. */
static bool project(const km_vec3 *w, int count, double *weight) {
  km_vec3 e[3], o = km_vec3_scale(-1.0, w[0]);
  for (int i = 1; i < count; ++i)
    e[i - 1] = km_vec3_sub(w[i], w[0]);
  weight[0] = 1.0;
  if (count == 1)
    return true;
  if (count == 2) {
    double square = km_vec3_dot(e[0], e[0]);
    weight[1] = km_vec3_dot(o, e[0]) / square;
    weight[0] = 1.0 - weight[1];
    return square > 0.0;
  }
  km_vec3 n = km_vec3_cross(e[0], e[1]);
  double square = km_vec3_dot(n, n), sides = km_vec3_dot(e[0], e[0]) * km_vec3_dot(e[1], e[1]);
  if (!(square > degenerate * degenerate * sides))
    return false;
  if (count == 3) {
    weight[1] = km_vec3_dot(km_vec3_cross(o, e[1]), n) / square;
    weight[2] = km_vec3_dot(km_vec3_cross(e[0], o), n) / square;
    weight[0] = 1.0 - weight[1] - weight[2];
    return true;
  }
  double volume = km_vec3_dot(n, e[2]);
  weight[1] = km_vec3_dot(o, km_vec3_cross(e[1], e[2])) / volume;
  weight[2] = km_vec3_dot(o, km_vec3_cross(e[2], e[0])) / volume;
  weight[3] = km_vec3_dot(o, n) / volume;
  weight[0] = 1.0 - weight[1] - weight[2] - weight[3];
  return volume * volume > degenerate * degenerate * square * km_vec3_dot(e[2], e[2]);
}

static km_vec3 weighted(const km_vec3 *w, const double *weight, int count) {
  km_vec3 sum = {0, 0, 0};
  for (int i = 0; i < count; ++i)
    sum = km_vec3_axpy(weight[i], w[i], sum);
  return sum;
}

/* Point of the simplex nearest to the origin; the simplex becomes the vertices on which it depends. */
static km_vec3 nearest_of(simplex *s) {
  km_vec3 nearest = {0, 0, 0};
  simplex best = {0};
  double least = HUGE_VAL;
  for (unsigned subset = 1; subset < 1u << s->count; ++subset) {
    simplex part = {0};
    km_vec3 w[4];
    for (int i = 0; i < s->count; ++i)
      if (subset >> i & 1u) {
        w[part.count] = s->p[i].w;
        part.p[part.count++] = s->p[i];
      }
    bool is_inside = project(w, part.count, part.weight);
    for (int i = 0; i < part.count; ++i)
      is_inside = is_inside && part.weight[i] >= 0.0;
    km_vec3 v = part.count == 4 ? (km_vec3){0, 0, 0} : weighted(w, part.weight, part.count);
    if (is_inside && km_vec3_dot(v, v) < least) {
      least = km_vec3_dot(v, v);
      nearest = v;
      best = part;
    }
  }
  *s = best;
  return nearest;
}

static bool has_point(const simplex *s, km_vec3 w) {
  for (int i = 0; i < s->count; ++i)
    if (s->p[i].w.x == w.x && s->p[i].w.y == w.y && s->p[i].w.z == w.z)
      return true;
  return false;
}

static double size_of(const km_difference_point *p, double size) {
  return fmax(size, fmax(km_vec3_norm(p->a), km_vec3_norm(p->b)));
}

/* Distance of the cores: nearest points, and the gap. Returns the size of the coordinates. */
static double core_distance(const km_convex_pair *pair, km_convex_distance *out) {
  km_vec3 first = km_vec3_sub(km_pose_point(&pair->pose, pair->part[1]->center), pair->part[0]->center);
  if (!(km_vec3_dot(first, first) > 0.0))
    first = (km_vec3){1, 0, 0};
  simplex s = {.count = 1, .p = {km_difference_support(pair, first)}, .weight = {1.0}};
  km_vec3 v = s.p[0].w, normal = {0, 0, 0};
  double size = size_of(&s.p[0], 0.0), length = km_vec3_norm(v), lower = -HUGE_VAL;
  for (int step = 0; step < MOST_STEPS && length > 0.0; ++step) {
    const km_vec3 towards = km_vec3_scale(-1.0 / length, v);
    km_difference_point p = km_difference_support(pair, towards);
    size = size_of(&p, size);
    double bound = -km_vec3_dot(towards, p.w);
    normal = bound > lower ? towards : normal;
    lower = fmax(lower, bound);
    if (length - lower <= gap_rounding * size || has_point(&s, p.w))
      break;
    simplex next = s;
    next.p[next.count++] = p;
    km_vec3 closer = nearest_of(&next);
    if (!(km_vec3_norm(closer) < length))
      break;
    s = next;
    v = closer;
    length = km_vec3_norm(v);
  }
  km_vec3 a[4], b[4];
  for (int i = 0; i < s.count; ++i) {
    a[i] = s.p[i].a;
    b[i] = s.p[i].b;
  }
  *out = (km_convex_distance){.distance = length,
                              .error = (length > 0.0 ? fmax(0.0, length - lower) : 0.0) + gap_rounding * size,
                              .normal = normal,
                              .a = weighted(a, s.weight, s.count),
                              .b = weighted(b, s.weight, s.count)};
  return size;
}

km_convex_distance km_convex_distance_compute(const km_convex_pair *pair) {
  km_convex_distance d;
  double size = core_distance(pair, &d), ra = pair->part[0]->radius, rb = pair->part[1]->radius;
  if (d.distance <= touching * size)
    km_convex_depth_compute(pair, size, &d);
  d.distance -= ra + rb;
  d.a = km_vec3_axpy(ra, d.normal, d.a);
  d.b = km_vec3_axpy(-rb, d.normal, d.b);
  return d;
}
