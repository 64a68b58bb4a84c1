/* Shapes of bodies as meshes and as solids. */
#include "exchange/mesh/shape_meshes.h"

#include "base/memory.h"

#include <math.h>

enum { AROUND = 32, ARCS = 8 }; /* facets about the axis; of a quarter circle */

static km_mesh *box(const double size[3]) {
  static const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  km_mesh *mesh = km_mesh_create(8, 12);
  for (int v = 0; mesh && v < 8; ++v)
    mesh->vertices[v] =
        (km_vec3){(v & 1 ? 0.5 : -0.5) * size[0], (v & 2 ? 0.5 : -0.5) * size[1], (v & 4 ? 0.5 : -0.5) * size[2]};
  for (int t = 0; mesh && t < 12; ++t)
    mesh->triangles[t] = (km_triangle){.corner = {faces[t][0], faces[t][1], faces[t][2]}};
  return mesh;
}

/* A surface of revolution about z from (radius, height) pairs that run upwards from a point of the axis to another
 * one. */
static km_mesh *turned(const double (*profile)[2], int rings) {
  km_mesh *mesh = km_mesh_create(rings * AROUND + 2, 2 * AROUND * rings);
  int top = rings * AROUND + 1, count = 0;
  if (!mesh)
    return NULL;
  mesh->vertices[0] = (km_vec3){0, 0, profile[0][1]};
  mesh->vertices[top] = (km_vec3){0, 0, profile[rings + 1][1]};
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < AROUND; ++k) {
      double angle = 2.0 * M_PI * k / AROUND;
      mesh->vertices[1 + r * AROUND + k] =
          (km_vec3){profile[r + 1][0] * cos(angle), profile[r + 1][0] * sin(angle), profile[r + 1][1]};
    }
  for (int k = 0; k < AROUND; ++k) {
    int next = (k + 1) % AROUND, last = 1 + (rings - 1) * AROUND;
    mesh->triangles[count++] = (km_triangle){.corner = {0, 1 + next, 1 + k}};
    mesh->triangles[count++] = (km_triangle){.corner = {top, last + k, last + next}};
    for (int r = 0; r + 1 < rings; ++r) {
      int a = 1 + r * AROUND + k, b = 1 + r * AROUND + next, c = a + AROUND, d = b + AROUND;
      mesh->triangles[count++] = (km_triangle){.corner = {a, b, c}};
      mesh->triangles[count++] = (km_triangle){.corner = {b, d, c}};
    }
  }
  return mesh;
}

/* Two half balls, `half` away from the middle. */
static km_mesh *capsule(double radius, double half) {
  double profile[2 * ARCS + 2][2];
  int rings = 0;
  profile[0][0] = 0.0;
  profile[0][1] = -half - radius;
  for (int k = 1; k < 2 * ARCS; ++k) {
    double angle = -0.5 * M_PI + 0.5 * M_PI * k / ARCS;
    if (k == ARCS && half > 0.0) { /* the lower end of the tube */
      profile[++rings][0] = radius;
      profile[rings][1] = -half;
    }
    profile[++rings][0] = radius * cos(angle);
    profile[rings][1] = (k < ARCS ? -half : half) + radius * sin(angle);
  }
  profile[rings + 1][0] = 0.0;
  profile[rings + 1][1] = half + radius;
  return turned((const double(*)[2])profile, rings);
}

static km_mesh *cylinder(double radius, double half) {
  const double profile[4][2] = {{0.0, -half}, {radius, -half}, {radius, half}, {0.0, half}};
  return turned(profile, 2);
}

km_status km_shape_mesh(const km_model *model, const km_model_shape *shape, km_mesh **out, km_error *error) {
  km_status status = KM_OK;
  const double *size = shape->size;
  *out = NULL;
  if (shape->kind == KM_SHAPE_OF_MESH)
    status = km_model_read_mesh(model, shape->where, "", shape->mesh, out, error);
  else if (shape->kind == KM_SHAPE_BOX)
    *out = box(size);
  else if (shape->kind == KM_SHAPE_CYLINDER)
    *out = cylinder(size[0], 0.5 * size[1]);
  else
    *out = capsule(size[0], shape->kind == KM_SHAPE_CAPSULE ? 0.5 * size[1] : 0.0);
  if (!status && !*out)
    status = km_fail(error, KM_MEMORY, "out of memory for meshes");
  if (status)
    return status;
  if (shape->kind == KM_SHAPE_OF_MESH)
    km_mesh_scale(*out, shape->scale);
  for (int v = 0; v < (*out)->vertex_count; ++v) /* NOLINT(*NullDereference): without a fault there is a mesh */
    (*out)->vertices[v] = km_pose_point(&shape->pose, (*out)->vertices[v]);
  return KM_OK;
}

bool km_shape_solid(const km_model_shape *shape, km_mass *out) {
  const double half[3] = {0.5 * shape->size[0], 0.5 * shape->size[1], 0.5 * shape->size[2]};
  const double ball[3] = {shape->size[0], shape->size[0], shape->size[0]};
  if (shape->kind == KM_SHAPE_OF_MESH)
    return false;
  *out = shape->kind == KM_SHAPE_BOX        ? km_solid_box(half)
         : shape->kind == KM_SHAPE_SPHERE   ? km_solid_ellipsoid(ball)
         : shape->kind == KM_SHAPE_CYLINDER ? km_solid_cylinder(shape->size[0], half[1])
                                            : km_solid_capsule(shape->size[0], half[1]);
  *out = km_mass_moved(&shape->pose, *out);
  return true;
}

km_status km_mesh_join(km_mesh **sum, km_mesh *part, km_error *error) {
  if (!*sum) {
    *sum = part;
    return KM_OK;
  }
  km_mesh *old = *sum,
          *both = km_mesh_create(old->vertex_count + part->vertex_count, old->triangle_count + part->triangle_count);
  for (int v = 0; both && v < both->vertex_count; ++v)
    both->vertices[v] = v < old->vertex_count ? old->vertices[v] : part->vertices[v - old->vertex_count];
  for (int t = 0; both && t < both->triangle_count; ++t) {
    bool first = t < old->triangle_count;
    both->triangles[t] = first ? old->triangles[t] : part->triangles[t - old->triangle_count];
    for (int k = 0; k < 3 && !first; ++k)
      both->triangles[t].corner[k] += old->vertex_count;
  }
  km_mesh_free(part);
  if (!both)
    return km_fail(error, KM_MEMORY, "out of memory for meshes");
  km_mesh_free(old);
  *sum = both;
  return KM_OK;
}
