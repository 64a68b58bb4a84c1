/* Triangle meshes. */
#include "model/geometry/mesh.h"

#include "base/memory.h"

#include <stdlib.h>

static const double weld_distance = 1e-6; /* relative to the mesh's size */

km_mesh *km_mesh_create(int vertex_count, int triangle_count) {
  km_mesh *mesh = KM_NEW(km_mesh, 1);
  if (!mesh)
    return NULL;
  *mesh = (km_mesh){vertex_count, triangle_count, KM_NEW(km_vec3, (size_t)vertex_count),
                    KM_NEW(km_triangle, (size_t)triangle_count)};
  if (mesh->vertices && mesh->triangles)
    return mesh;
  km_mesh_free(mesh);
  return NULL;
}

void km_mesh_free(km_mesh *mesh) {
  if (!mesh)
    return;
  km_free(mesh->vertices);
  km_free(mesh->triangles);
  km_free(mesh);
}

void km_mesh_box(const km_mesh *mesh, km_vec3 *low, km_vec3 *high) {
  km_vec3 l = {0, 0, 0}, h = l;
  for (int i = 0; i < mesh->vertex_count; ++i) {
    km_vec3 v = mesh->vertices[i];
    l = i ? (km_vec3){fmin(l.x, v.x), fmin(l.y, v.y), fmin(l.z, v.z)} : v;
    h = i ? (km_vec3){fmax(h.x, v.x), fmax(h.y, v.y), fmax(h.z, v.z)} : v;
  }
  *low = l;
  *high = h;
}

void km_mesh_scale(km_mesh *mesh, const double by[3]) {
  for (int v = 0; v < mesh->vertex_count; ++v) {
    km_vec3 *p = &mesh->vertices[v];
    *p = (km_vec3){by[0] * p->x, by[1] * p->y, by[2] * p->z};
  }
  for (int t = 0; t < mesh->triangle_count && by[0] * by[1] * by[2] < 0.0; ++t) {
    int corner = mesh->triangles[t].corner[1];
    mesh->triangles[t].corner[1] = mesh->triangles[t].corner[2];
    mesh->triangles[t].corner[2] = corner;
  }
}

typedef struct sorted {
  double along;
  int vertex;
} sorted;

static int by_place(const void *a, const void *b) {
  const sorted *x = a, *y = b;
  if (x->along != y->along)
    return x->along < y->along ? -1 : 1;
  return (x->vertex > y->vertex) - (x->vertex < y->vertex);
}

/* same[i]: vertex that replaces vertex i. */
static void find_same(const km_mesh *mesh, sorted *order, int *same) {
  /* Vertices are sorted along a direction that isn't perpendicular to usual edges, so that few have equal keys. */
  const km_vec3 direction = {0.8523, 0.4318, 0.2951};
  km_vec3 low, high;
  km_mesh_box(mesh, &low, &high);
  double near = weld_distance * km_vec3_norm(km_vec3_sub(high, low));
  int count = mesh->vertex_count;
  for (int i = 0; i < count; ++i) {
    order[i] = (sorted){km_vec3_dot(direction, km_vec3_sub(mesh->vertices[i], mesh->vertices[0])), i};
    same[i] = -1;
  }
  qsort(order, (size_t)count, sizeof *order, by_place);
  for (int i = 0; i < count; ++i) {
    int first = order[i].vertex;
    if (same[first] >= 0)
      continue;
    same[first] = first;
    for (int k = i + 1; k < count && order[k].along - order[i].along <= near; ++k) {
      int other = order[k].vertex;
      if (same[other] < 0 && km_vec3_norm(km_vec3_sub(mesh->vertices[other], mesh->vertices[first])) <= near)
        same[other] = first;
    }
  }
}

/* Renumbers the remaining vertices and the triangles. */
static void join(km_mesh *mesh, const int *same, int *number) {
  int vertices = 0, triangles = 0;
  for (int i = 0; i < mesh->vertex_count; ++i)
    if (same[i] == i) {
      number[i] = vertices;
      mesh->vertices[vertices++] = mesh->vertices[i];
    }
  for (int t = 0; t < mesh->triangle_count; ++t) {
    const int *c = mesh->triangles[t].corner;
    km_triangle triangle = {{number[same[c[0]]], number[same[c[1]]], number[same[c[2]]]}, mesh->triangles[t].color};
    c = triangle.corner;
    if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0])
      mesh->triangles[triangles++] = triangle;
  }
  mesh->vertex_count = vertices;
  mesh->triangle_count = triangles;
}

bool km_mesh_weld(km_mesh *mesh) {
  size_t count = (size_t)mesh->vertex_count;
  if (count == 0)
    return true;
  sorted *order = KM_NEW(sorted, count);
  int *same = KM_NEW(int, count), *number = KM_NEW(int, count);
  bool done = order && same && number;
  if (done) {
    find_same(mesh, order, same);
    join(mesh, same, number);
  }
  km_free(order);
  km_free(same);
  km_free(number);
  return done;
}
