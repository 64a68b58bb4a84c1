/* Looking for the files of meshes and reading them. */
#include "exchange/mesh/model_meshes.h"
#include "exchange/mesh/shapes.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

static bool try_folder(const km_model *model, const char *folder, const char *name, km_text *path) {
  path->size = 0;
  if (name[0] != '/')
    km_text_format(path, "%s/", folder[0] == '/' ? folder : model->folder);
  if (name[0] != '/' && folder[0] != '/' && folder[0])
    km_text_format(path, "%s/", folder);
  km_text_add(path, name);
  return !path->failed && access(path->data, R_OK) == 0;
}

bool km_model_find_mesh(const km_model *model, const char *name, km_text *path) {
  if (try_folder(model, "", name, path))
    return true;
  for (int i = 0; i < model->include_dir_count; ++i)
    if (try_folder(model, model->include_dirs[i], name, path))
      return true;
  return false;
}

km_status km_body_mesh(const km_model *model, const km_model_body *body, km_mesh **out, km_error *error) {
  km_text path = {0};
  km_status status = KM_OK;
  if (!km_model_find_mesh(model, body->mesh, &path))
    status = km_fail(error, KM_IO, "%s.definition: mesh \"%.200s\" is found neither beside the file nor in include_dir",
                     body->where, body->mesh);
  else
    status = km_mesh_read(path.data, out, error);
  km_text_free(&path);
  return status;
}

static void paint(km_mesh *mesh, const double color[4]) {
  unsigned code = 1;
  for (int k = 0; k < 3; ++k)
    code = code << 8 | (unsigned)lround(255.0 * color[k]);
  for (int t = 0; t < mesh->triangle_count; ++t)
    mesh->triangles[t].color = color[3] > 0.0 ? code : 0;
}

km_status km_model_read_meshes(const km_model *model, km_mesh ***meshes, km_error *error) {
  int count = 0;
  km_status status = KM_OK;
  km_mesh **list = *meshes = KM_NEW(km_mesh *, (size_t)model->body_count);
  if (!list)
    return km_fail(error, KM_MEMORY, "out of memory for meshes");
  for (int b = 1; b < model->body_count && !status; ++b)
    if (model->bodies[b].mesh) {
      ++count;
      status = km_body_mesh(model, &model->bodies[b], &list[b], error);
    }
  for (int s = 0; s < model->shape_count && !status; ++s, ++count) {
    km_mesh *part = NULL;
    if (model->shapes[s].color[3] == 0.0) /* it can't be seen */
      continue;
    status = km_shape_mesh(model, &model->shapes[s], &part, error);
    if (!status) {
      paint(part, model->shapes[s].color);
      status = km_mesh_join(&list[model->shapes[s].body], part, error);
    }
  }
  if (!status && count == 0)
    return km_fail(error, KM_USAGE,
                   "no body has a mesh; expected a definition or shapes, such as \"definition\": "
                   "[\"arm.obj\"]");
  return status;
}

void km_meshes_free(const km_model *model, km_mesh **meshes) {
  for (int b = 0; meshes && b < model->body_count; ++b)
    km_mesh_free(meshes[b]);
  km_free(meshes);
}
