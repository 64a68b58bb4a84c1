/* Convex parts of bodies: plain shapes exactly, meshes by the hulls of their connected components. */
#include "clearance/body_parts.h"

#include "base/number/union_find.h"
#include "clearance/hull_error.h"
#include "exchange/mesh/model_meshes.h"
#include "model/geometry/hull.h"

#include <string.h>

typedef struct builder {
  const km_model *model;
  km_arena *arena;
  km_convex *parts;
  size_t count, capacity;
  double error; /* km_hull_error of the body, the largest of its meshes */
} builder;

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the parts of bodies");
}

/* Adds a part with its ball: around the middle of the points' box. */
static km_status add_part(builder *b, km_convex part, km_error *error) {
  void *parts = b->parts;
  if (b->arena->failed || !km_arena_grow(b->arena, &parts, &b->capacity, b->count + 1, sizeof *b->parts))
    return no_memory(error);
  b->parts = parts;
  km_vec3 low = part.points[0], high = low;
  for (int i = 1; i < part.count; ++i) {
    const km_vec3 p = part.points[i];
    low = (km_vec3){fmin(low.x, p.x), fmin(low.y, p.y), fmin(low.z, p.z)};
    high = (km_vec3){fmax(high.x, p.x), fmax(high.y, p.y), fmax(high.z, p.z)};
  }
  part.center = km_vec3_scale(0.5, km_vec3_add(low, high));
  for (int i = 0; i < part.count; ++i)
    part.reach = fmax(part.reach, km_vec3_norm(km_vec3_sub(part.points[i], part.center)));
  part.reach = hypot(part.reach, part.disc) + part.radius;
  b->parts[b->count++] = part;
  return KM_OK;
}

/* A box has its corners, a sphere its centre, capsules and cylinders the ends of their axes. */
static km_status add_shape(builder *b, const km_model_shape *shape, km_error *error) {
  const double *size = shape->size;
  bool is_box = shape->kind == KM_SHAPE_BOX, is_sphere = shape->kind == KM_SHAPE_SPHERE;
  int count = is_box ? 8 : is_sphere ? 1 : 2;
  km_vec3 *points = KM_ARENA_NEW(b->arena, km_vec3, (size_t)count);
  for (int i = 0; i < count && points; ++i) {
    km_vec3 p = is_box ? (km_vec3){(i & 1 ? 0.5 : -0.5) * size[0], (i & 2 ? 0.5 : -0.5) * size[1],
                                   (i & 4 ? 0.5 : -0.5) * size[2]}
                       : (km_vec3){0, 0, is_sphere ? 0.0 : (i ? 0.5 : -0.5) * size[1]};
    points[i] = km_pose_point(&shape->pose, p);
  }
  if (!points)
    return no_memory(error);
  return add_part(b,
                  (km_convex){.count = count,
                              .points = points,
                              .radius = is_sphere || shape->kind == KM_SHAPE_CAPSULE ? size[0] : 0.0,
                              .disc = shape->kind == KM_SHAPE_CYLINDER ? size[0] : 0.0,
                              .axis = km_rotate(&shape->pose.R, (km_vec3){0, 0, 1})},
                  error);
}

/* ---- Meshes */

/* Component of each vertex: -1, -2, … Returns their number. A vertex of no triangle is one of its own. */
static int number_components(const km_mesh *mesh, int *component) {
  int count = 0, n = mesh->vertex_count;
  km_sets_reset(component, n);
  for (int t = 0; t < mesh->triangle_count; ++t)
    for (int k = 1; k < 3; ++k) {
      int a = km_set_root(component, mesh->triangles[t].corner[0]),
          b = km_set_root(component, mesh->triangles[t].corner[k]);
      component[a > b ? a : b] = a > b ? b : a;
    }
  for (int v = 0; v < n; ++v) /* a root is the first vertex of its component */
    component[v] = component[v] == v ? --count : component[component[v]];
  return -count;
}

/* Triangles of one component with their vertices. The caller frees it; NULL without memory. */
static km_mesh *take_component(const km_mesh *mesh, const int *component, int which, int *place) {
  int vertices = 0, triangles = 0;
  for (int v = 0; v < mesh->vertex_count; ++v)
    if (component[v] == which)
      place[v] = vertices++;
  for (int t = 0; t < mesh->triangle_count; ++t)
    triangles += component[mesh->triangles[t].corner[0]] == which;
  km_mesh *part = km_mesh_create(vertices, triangles);
  for (int v = 0; v < mesh->vertex_count && part; ++v)
    if (component[v] == which)
      part->vertices[place[v]] = mesh->vertices[v];
  for (int t = 0, i = 0; t < mesh->triangle_count && part; ++t)
    if (component[mesh->triangles[t].corner[0]] == which) {
      for (int k = 0; k < 3; ++k)
        part->triangles[i].corner[k] = place[mesh->triangles[t].corner[k]];
      ++i;
    }
  return part;
}

static double diagonal_of(const km_mesh *mesh) {
  km_vec3 low, high;
  km_mesh_box(mesh, &low, &high);
  return km_vec3_norm(km_vec3_sub(high, low));
}

/* Adds the hull of a component. Where all its vertices are in a plane they are the part themselves, and the error is
 * bounded by half of the size. */
static km_status add_component(builder *b, const km_mesh *part, km_error *error) {
  km_mesh *hull = NULL;
  double size = diagonal_of(part);
  km_status status = km_mesh_hull(part, &hull, error);
  bool is_flat = status == KM_MODEL;
  if (status && !is_flat)
    return status;
  const km_mesh *of = is_flat ? part : hull;
  km_vec3 *points = KM_ARENA_NEW(b->arena, km_vec3, (size_t)of->vertex_count);
  if (points)
    memcpy(points, of->vertices, (size_t)of->vertex_count * sizeof *points);
  double off = is_flat ? (part->triangle_count > 1 ? 0.5 * size : 0.0) : km_hull_error(part, hull, size);
  b->error = fmax(b->error, off);
  status = points && off < HUGE_VAL ? add_part(b, (km_convex){.count = of->vertex_count, .points = points}, error)
                                    : no_memory(error);
  km_mesh_free(hull);
  return status;
}

static km_status add_mesh(builder *b, const km_mesh *mesh, km_error *error) {
  km_arena scratch = {0};
  int *component = KM_ARENA_NEW(&scratch, int, (size_t)mesh->vertex_count + 1);
  int *place = KM_ARENA_NEW(&scratch, int, (size_t)mesh->vertex_count + 1);
  km_status status = scratch.failed ? no_memory(error) : KM_OK;
  int count = status ? 0 : number_components(mesh, component);
  for (int i = 1; i <= count && !status; ++i) {
    km_mesh *part = take_component(mesh, component, -i, place);
    if (!part)
      status = no_memory(error);
    else if (part->triangle_count > 0)
      status = add_component(b, part, error);
    km_mesh_free(part);
  }
  km_arena_free(&scratch);
  return status;
}

/* ---- Bodies */

static km_status add_read_mesh(builder *b, const km_model_shape *shape, int body, km_error *error) {
  km_mesh *mesh = NULL;
  km_status status = shape ? km_model_read_mesh(b->model, shape->where, "", shape->mesh, &mesh, error)
                           : km_body_mesh(b->model, &b->model->bodies[body], &mesh, error);
  if (status)
    return status;
  if (shape) {
    km_mesh_scale(mesh, shape->scale);
    for (int v = 0; v < mesh->vertex_count; ++v)
      mesh->vertices[v] = km_pose_point(&shape->pose, mesh->vertices[v]);
  }
  status = add_mesh(b, mesh, error);
  km_mesh_free(mesh);
  return status;
}

static km_status add_body(builder *b, int body, km_error *error) {
  const km_model *model = b->model;
  km_status status = model->bodies[body].mesh ? add_read_mesh(b, NULL, body, error) : KM_OK;
  for (int i = 0; i < model->shape_count && !status; ++i)
    if (model->shapes[i].body == body)
      status = model->shapes[i].kind == KM_SHAPE_OF_MESH ? add_read_mesh(b, &model->shapes[i], body, error)
                                                         : add_shape(b, &model->shapes[i], error);
  return status;
}

bool km_body_has_geometry(const km_model *model, int body) {
  for (int i = 0; i < model->shape_count; ++i)
    if (model->shapes[i].body == body)
      return true;
  return model->bodies[body].mesh != NULL;
}

km_status km_body_parts_create(const km_model *model, const bool *wanted, km_arena *arena, km_body_parts *out,
                               km_error *error) {
  builder b = {.model = model, .arena = arena};
  out->start = KM_ARENA_NEW(arena, int, (size_t)model->body_count + 1);
  out->error = KM_ARENA_NEW(arena, double, (size_t)model->body_count + 1);
  km_status status = arena->failed ? no_memory(error) : KM_OK;
  for (int body = 0; body < model->body_count && !status; ++body) {
    out->start[body] = (int)b.count;
    b.error = 0.0;
    status = wanted[body] ? add_body(&b, body, error) : KM_OK;
    out->error[body] = b.error;
    out->start[body + 1] = (int)b.count;
  }
  out->parts = b.parts;
  return status;
}
