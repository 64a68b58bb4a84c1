#include "model/model.h"

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
  const km_value *dirs = km_value_get(km_value_get(model->root, "model_parameters"), "include_dir");
  if (dirs && dirs->kind == KM_STRING)
    return try_folder(model, dirs->string, name, path);
  for (const km_value *d = dirs ? dirs->first : NULL; d; d = d->next)
    if (try_folder(model, d->string, name, path))
      return true;
  return false;
}
