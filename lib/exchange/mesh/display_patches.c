/* A body's mesh and shapes as triangles for programs that show them. */
#include "base/arguments.h"
#include "exchange/mesh/shape_meshes.h"
#include "kmech/inspect.h"

#include <string.h>

static bool has_body(const km_model *model, int body) {
  return model && body >= 0 && body < model->body_count;
}

/* The shape that is part `index` of a body; NULL: there is none. */
static const km_model_shape *shape_of(const km_model *model, int body, int index) {
  for (int s = 0; s < model->shape_count; ++s)
    if (model->shapes[s].body == body && index-- == 0)
      return &model->shapes[s];
  return NULL;
}

int km_body_patch_count(const km_model *model, int body) {
  if (!has_body(model, body))
    return 0;
  int count = model->bodies[body].mesh ? 1 : 0;
  for (int s = 0; s < model->shape_count; ++s)
    count += model->shapes[s].body == body;
  return count;
}

static bool copy(const km_mesh *mesh, km_surface_patch *out) {
  out->vertices = KM_NEW(double, 3 * (size_t)mesh->vertex_count + 1);
  out->triangles = KM_NEW(int, 3 * (size_t)mesh->triangle_count + 1);
  if (!out->vertices || !out->triangles)
    return false;
  for (int v = 0; v < mesh->vertex_count; ++v) {
    km_vec3 p = mesh->vertices[v];
    km_vec3_write(p, out->vertices + 3 * v);
  }
  for (int t = 0; t < mesh->triangle_count; ++t)
    memcpy(out->triangles + 3 * t, mesh->triangles[t].corner, 3 * sizeof(int));
  out->vertex_count = mesh->vertex_count;
  out->triangle_count = mesh->triangle_count;
  return true;
}

km_status km_body_patch(const km_model *model, int body, int index, km_surface_patch *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_surface_patch){.color = {0.0, 0.0, 0.0, -1.0}};
  km_status status = km_check_given(model != NULL, "model", error);
  if (!status)
    status = km_check_index(body, model->body_count, "body", error);
  if (!status)
    status = km_check_index(index, km_body_patch_count(model, body), "part of the body's surface", error);
  if (status)
    return status;
  bool own = model->bodies[body].mesh != NULL;
  km_mesh *mesh = NULL;
  if (own && index == 0) {
    status = km_body_mesh(model, &model->bodies[body], &mesh, error);
  } else {
    const km_model_shape *shape = shape_of(model, body, index - own);
    status = km_shape_mesh(model, shape, &mesh, error);
    memcpy(out->color, shape->color, sizeof out->color);
  }
  if (!status && !copy(mesh, out))
    status = km_fail(error, KM_MEMORY, "out of memory for a surface");
  km_mesh_free(mesh);
  return status;
}

void km_surface_patch_free(km_surface_patch *patch) {
  if (!patch)
    return;
  km_free(patch->vertices);
  km_free(patch->triangles);
  *patch = (km_surface_patch){.color = {0.0, 0.0, 0.0, -1.0}};
}
