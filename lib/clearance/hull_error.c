/* Directed Hausdorff distance from a hull's surface to a mesh, by branch and bound over triangles.
 *
 *   e(x)  distance of x from the mesh = min over its triangles T of dist(x, T)
 *   S     part of a hull's triangle, T* the triangle nearest to its centre:
 *         e(centre) ≤ max over S of e ≤ max over the corners of S of dist(corner, T*),  as dist(·, T*) is convex
 *
 * A part whose upper bound is not above the largest e(centre) by more than the tolerance isn't divided further. */
#include "clearance/hull_error.h"

#include "model/geometry/mass_properties.h"

#include <math.h>

/* Rounding of hulls (km_mesh_hull), with the turn of thin faces; tolerance of the bound. */
static const double coplanar = 1e-8, tolerance = 1e-2;
enum { DEEPEST = 10 }; /* divisions of a triangle by four */

typedef struct surface {
  const km_mesh *mesh;
  km_vec3 *center; /* [triangle] ball around it */
  double *radius;
} surface;

static const km_vec3 *corner(const km_mesh *mesh, int triangle, int k) {
  return &mesh->vertices[mesh->triangles[triangle].corner[k]];
}

static double to_segment(km_vec3 x, km_vec3 a, km_vec3 b) {
  km_vec3 e = km_vec3_sub(b, a), d = km_vec3_sub(x, a);
  double square = km_vec3_dot(e, e), t = square > 0.0 ? km_vec3_dot(d, e) / square : 0.0;
  return km_vec3_norm(km_vec3_axpy(-fmin(1.0, fmax(0.0, t)), e, d));
}

/* Distance of a point from a triangle: from its plane where it projects into it, else from an edge. */
static double to_triangle(km_vec3 x, const km_mesh *mesh, int triangle) {
  const km_vec3 a = *corner(mesh, triangle, 0), b = *corner(mesh, triangle, 1), c = *corner(mesh, triangle, 2);
  const km_vec3 e = km_vec3_sub(b, a), g = km_vec3_sub(c, a), n = km_vec3_cross(e, g), d = km_vec3_sub(x, a);
  double square = km_vec3_dot(n, n), u = km_vec3_dot(km_vec3_cross(d, g), n), v = km_vec3_dot(km_vec3_cross(e, d), n);
  if (u >= 0.0 && v >= 0.0 && u + v <= square && square > 0.0)
    return fabs(km_vec3_dot(d, n)) / sqrt(square);
  return fmin(to_segment(x, a, b), fmin(to_segment(x, b, c), to_segment(x, c, a)));
}

static int nearest_triangle(const surface *s, km_vec3 x, double *distance) {
  int nearest = -1;
  *distance = HUGE_VAL;
  for (int t = 0; t < s->mesh->triangle_count; ++t) {
    if (km_vec3_norm(km_vec3_sub(x, s->center[t])) - s->radius[t] >= *distance)
      continue;
    double d = to_triangle(x, s->mesh, t);
    nearest = d < *distance ? t : nearest;
    *distance = fmin(*distance, d);
  }
  return nearest;
}

static km_vec3 middle(km_vec3 a, km_vec3 b) {
  return km_vec3_scale(0.5, km_vec3_add(a, b));
}

/* Bound over a part of a hull's triangle; `*known` is the largest exact distance so far. */
static double bound_of(const surface *s, const km_vec3 p[3], double size, int depth, double *known) {
  km_vec3 center = km_vec3_scale(1.0 / 3.0, km_vec3_add(p[0], km_vec3_add(p[1], p[2])));
  double exact, bound = 0.0;
  int nearest = nearest_triangle(s, center, &exact);
  *known = fmax(*known, exact);
  for (int k = 0; k < 3; ++k)
    bound = fmax(bound, to_triangle(p[k], s->mesh, nearest));
  if (bound <= *known + tolerance * size || depth == DEEPEST)
    return bound;
  const km_vec3 m[3] = {middle(p[1], p[2]), middle(p[2], p[0]), middle(p[0], p[1])};
  const km_vec3 parts[4][3] = {{p[0], m[2], m[1]}, {m[2], p[1], m[0]}, {m[1], m[0], p[2]}, {m[0], m[1], m[2]}};
  bound = 0.0;
  for (int k = 0; k < 4; ++k)
    bound = fmax(bound, bound_of(s, parts[k], size, depth + 1, known));
  return bound;
}

/* True if a triangle of the mesh lies in a face of the hull. */
static bool is_on_hull(const km_mesh *mesh, int triangle, const km_mesh *hull, double height) {
  for (int t = 0; t < hull->triangle_count; ++t) {
    const km_vec3 a = *corner(hull, t, 0);
    km_vec3 n = km_vec3_cross(km_vec3_sub(*corner(hull, t, 1), a), km_vec3_sub(*corner(hull, t, 2), a));
    double most = height * km_vec3_norm(n);
    bool is_on = true;
    for (int k = 0; k < 3 && is_on; ++k)
      is_on = fabs(km_vec3_dot(n, km_vec3_sub(*corner(mesh, triangle, k), a))) <= most;
    if (is_on)
      return true;
  }
  return false;
}

/* A closed surface in the hull's is the hull's. */
static bool is_convex(const km_mesh *mesh, const km_mesh *hull, double size) {
  km_mesh_faults faults;
  if (km_mesh_check(mesh, &faults, NULL) || faults.open_edges > 0)
    return false;
  for (int t = 0; t < mesh->triangle_count; ++t)
    if (!is_on_hull(mesh, t, hull, coplanar * size))
      return false;
  return true;
}

double km_hull_error(const km_mesh *mesh, const km_mesh *hull, double size) {
  if (is_convex(mesh, hull, size))
    return coplanar * size;
  km_arena arena = {0};
  surface s = {mesh, KM_ARENA_NEW(&arena, km_vec3, (size_t)mesh->triangle_count + 1),
               KM_ARENA_NEW(&arena, double, (size_t)mesh->triangle_count + 1)};
  double bound = arena.failed ? HUGE_VAL : 0.0, known = 0.0;
  for (int t = 0; t < mesh->triangle_count && !arena.failed; ++t) {
    s.center[t] = middle(*corner(mesh, t, 0), *corner(mesh, t, 1));
    for (int k = 0; k < 3; ++k)
      s.radius[t] = fmax(s.radius[t], km_vec3_norm(km_vec3_sub(*corner(mesh, t, k), s.center[t])));
  }
  for (int t = 0; t < hull->triangle_count && !arena.failed; ++t) {
    const km_vec3 p[3] = {*corner(hull, t, 0), *corner(hull, t, 1), *corner(hull, t, 2)};
    bound = fmax(bound, bound_of(&s, p, size, 0, &known));
  }
  km_arena_free(&arena);
  return bound;
}
