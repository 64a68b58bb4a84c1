/* Looking for the files of meshes, reading and identifying them. */
#include "exchange/mesh/model_meshes.h"
#include "exchange/mesh/shape_meshes.h"

#include "base/arguments.h"
#include "base/store/store_file.h"
#include "kmech/report.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

static bool try_folder(const km_folders *folders, const char *folder, const char *name, km_text *path) {
  path->size = 0;
  if (name[0] != '/')
    km_text_format(path, "%s/", folder[0] == '/' ? folder : folders->folder);
  if (name[0] != '/' && folder[0] != '/' && folder[0])
    km_text_format(path, "%s/", folder);
  km_text_add(path, name);
  return !path->failed && access(path->data, R_OK) == 0;
}

bool km_find_mesh(const km_folders *folders, const char *name, km_text *path) {
  if (try_folder(folders, "", name, path))
    return true;
  for (int i = 0; i < folders->include_dir_count; ++i)
    if (try_folder(folders, folders->include_dirs[i], name, path))
      return true;
  return false;
}

km_status km_model_read_mesh(const km_model *model, const char *where, const char *part, const char *name,
                             km_mesh **out, km_error *error) {
  km_text path = {0};
  km_status status = KM_OK;
  if (!km_find_mesh(&model->folders, name, &path))
    status = path.failed
                 ? km_fail(error, KM_MEMORY, "out of memory for meshes")
                 : km_fail(error, KM_IO, "%s%s: mesh \"%.200s\" is found neither beside the file nor in include_dir",
                           where, part, name);
  else
    status = km_mesh_read(path.data, out, error);
  km_text_free(&path);
  return status;
}

km_status km_body_mesh(const km_model *model, const km_model_body *body, km_mesh **out, km_error *error) {
  return km_model_read_mesh(model, body->where, ".definition", body->mesh, out, error);
}

/* Appends the hashes of a mesh (NULL: none). False when out of memory. */
static bool identify_mesh(const km_model *model, const char *name, km_text *out) {
  km_mesh *mesh = NULL;
  km_error ignored; /* the user of the mesh reports it */
  if (!name)
    return true;
  if (km_model_read_mesh(model, "", "", name, &mesh, &ignored) == KM_MEMORY)
    return false;
  if (mesh) {
    km_identity_add_bytes(out, mesh->vertices, (size_t)mesh->vertex_count * sizeof *mesh->vertices);
    km_identity_add_bytes(out, mesh->triangles, (size_t)mesh->triangle_count * sizeof *mesh->triangles);
  } else {
    km_identity_add_name(out, "");
  }
  km_mesh_free(mesh);
  return !out->failed;
}

km_status km_model_identify_meshes(const km_model *model, km_text *out, km_error *error) {
  bool is_ok = true;
  for (int b = 0; is_ok && b < model->body_count; ++b)
    is_ok = identify_mesh(model, model->bodies[b].mesh, out);
  for (int s = 0; is_ok && s < model->shape_count; ++s)
    is_ok = identify_mesh(model, model->shapes[s].mesh, out);
  return is_ok ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for meshes");
}

static void paint(km_mesh *mesh, const double color[4]) {
  unsigned code = 1;
  for (int k = 0; k < 3; ++k)
    code = code << 8 | (unsigned)lround(255.0 * color[k]);
  for (int t = 0; t < mesh->triangle_count; ++t)
    mesh->triangles[t].color = color[3] > 0.0 ? code : 0;
}

/* Adds a shape to its body's mesh, unless it can't be seen. */
static km_status add_shape(const km_model *model, const km_model_shape *shape, km_meshes *meshes, km_error *error) {
  km_mesh *part = NULL;
  if (shape->color[3] == 0.0)
    return KM_OK;
  km_status status = km_shape_mesh(model, shape, &part, error);
  if (status)
    return status;
  paint(part, shape->color);
  return km_mesh_join(&meshes->items[shape->body], part, error);
}

static km_status read_all(const km_model *model, km_meshes *meshes, km_error *error) {
  int count = model->shape_count;
  km_status status = KM_OK;
  for (int b = 1; b < model->body_count && !status; ++b)
    if (model->bodies[b].mesh) {
      ++count;
      status = km_body_mesh(model, &model->bodies[b], &meshes->items[b], error);
    }
  for (int s = 0; s < model->shape_count && !status; ++s)
    status = add_shape(model, &model->shapes[s], meshes, error);
  if (!status && count == 0)
    return km_fail(error, KM_USAGE,
                   "no body has a mesh; expected a definition or shapes, such as \"definition\": "
                   "[\"arm.obj\"]");
  return status;
}

km_status km_model_read_meshes(const km_model *model, km_meshes **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the meshes", error);
  *out = NULL;
  km_status status = km_check_given(model != NULL, "model", error);
  if (status)
    return status;
  km_meshes *meshes = km_alloc(1, sizeof *meshes + (size_t)model->body_count * sizeof *meshes->items);
  if (!meshes)
    return km_fail(error, KM_MEMORY, "out of memory for meshes");
  meshes->count = model->body_count;
  status = read_all(model, meshes, error);
  if (!status)
    *out = meshes;
  else
    km_meshes_free(meshes);
  return status;
}

void km_meshes_free(km_meshes *meshes) {
  for (int b = 0; meshes && b < meshes->count; ++b)
    km_mesh_free(meshes->items[b]);
  km_free(meshes);
}
