/* Directed Hausdorff distance from a hull's surface to a mesh, by branch and bound over triangles.
 *
 *   e(x)  distance of x from the mesh = min over its triangles T of dist(x, T)
 *   S     part of a hull's triangle, T* the triangle nearest to its centre:
 *         e(centre) ≤ max over S of e ≤ max over the corners of S of dist(corner, T*),  as dist(·, T*) is convex
 *
 * A part whose upper bound is not above the largest e(centre) by more than the tolerance isn't divided further. */
#include "clearance/hull_error.h"

#include "clearance/triangle_tree.h"
#include "model/geometry/mass_properties.h"

#include <math.h>

/* Rounding of hulls (km_mesh_hull), with the turn of thin faces; tolerance of the bound; both in sizes. */
static const double coplanar = 1e-8, tolerance = 2e-3;
/* Triangles that are lower than this, in sizes, have no certain plane, and cover nothing. */
static const double sliver = 1e-6;
enum { DEEPEST = 12 }; /* divisions of a triangle by four */

static km_vec3 corner(const km_mesh *mesh, int triangle, int k) {
  return mesh->vertices[mesh->triangles[triangle].corner[k]];
}

static km_vec3 middle(km_vec3 a, km_vec3 b) {
  return km_vec3_scale(0.5, km_vec3_add(a, b));
}

/* Bound over a part of a hull's triangle; `*known` is the largest exact distance so far. */
static double bound_of(const km_triangle_tree *tree, const km_mesh *mesh, const km_vec3 p[3], double size, int depth,
                       double *known) {
  km_vec3 center = km_vec3_scale(1.0 / 3.0, km_vec3_add(p[0], km_vec3_add(p[1], p[2])));
  double exact, bound = 0.0;
  int nearest = km_triangle_tree_nearest(tree, center, &exact);
  *known = fmax(*known, exact);
  for (int k = 0; k < 3; ++k)
    bound = fmax(bound, km_triangle_distance(mesh, nearest, p[k]));
  if (bound <= *known + tolerance * size || depth == DEEPEST)
    return bound;
  const km_vec3 m[3] = {middle(p[1], p[2]), middle(p[2], p[0]), middle(p[0], p[1])};
  const km_vec3 parts[4][3] = {{p[0], m[2], m[1]}, {m[2], p[1], m[0]}, {m[1], m[0], p[2]}, {m[0], m[1], m[2]}};
  bound = 0.0;
  for (int k = 0; k < 4; ++k)
    bound = fmax(bound, bound_of(tree, mesh, parts[k], size, depth + 1, known));
  return bound;
}

/* True if no vertex of the hull is above the triangle's plane, so that the triangle is a part of the hull's surface. */
static bool is_on_hull(const km_mesh *mesh, int triangle, const km_mesh *hull, double size) {
  const km_vec3 a = corner(mesh, triangle, 0), e = km_vec3_sub(corner(mesh, triangle, 1), a),
                g = km_vec3_sub(corner(mesh, triangle, 2), a), n = km_vec3_cross(e, g);
  double area = km_vec3_norm(n), longest = fmax(km_vec3_norm(e), km_vec3_norm(g)), most = coplanar * size * area;
  if (area <= sliver * size * longest)
    return true;
  most *= fmax(1.0, size * longest / area); /* rounding of the vertices turns the plane of a low triangle */
  for (int v = 0; v < hull->vertex_count; ++v)
    if (km_vec3_dot(n, km_vec3_sub(hull->vertices[v], a)) > most)
      return false;
  return true;
}

/* A closed surface in the hull's is the hull's. `*failed`: without memory. */
static bool is_convex(const km_mesh *mesh, const km_mesh *hull, double size, bool *failed) {
  km_mesh_faults faults;
  *failed = km_mesh_check(mesh, &faults, NULL) != KM_OK;
  if (*failed || faults.open_edges > 0 || faults.mixed_edges > 0)
    return false;
  for (int t = 0; t < mesh->triangle_count; ++t)
    if (!is_on_hull(mesh, t, hull, size))
      return false;
  return true;
}

double km_hull_error(const km_mesh *mesh, const km_mesh *hull, double size) {
  bool failed;
  if (is_convex(mesh, hull, size, &failed))
    return coplanar * size;
  if (failed)
    return HUGE_VAL;
  km_arena arena = {0};
  const km_triangle_tree *tree = km_triangle_tree_create(mesh, &arena);
  double bound = tree ? 0.0 : HUGE_VAL, known = 0.0;
  for (int t = 0; t < hull->triangle_count && tree; ++t) {
    const km_vec3 p[3] = {corner(hull, t, 0), corner(hull, t, 1), corner(hull, t, 2)};
    bound = fmax(bound, bound_of(tree, mesh, p, size, 0, &known));
  }
  km_arena_free(&arena);
  return bound;
}
