/* Mass properties of bodies from their meshes and densities. */
#include "exchange/mesh/model_meshes.h"
#include "model/mass_properties.h"

static const char not_found[] = "is found neither beside the file nor in include_dir";

static km_status check_closed(const km_mesh *mesh, const char *path, km_error *error) {
  km_mesh_faults faults;
  km_status status = km_mesh_check(mesh, &faults, error);
  if (status)
    return status;
  if (faults.open_edges)
    return km_fail(error, KM_MODEL, "%s: has %d open edge%s; expected a closed surface to go with a density", path,
                   faults.open_edges, faults.open_edges == 1 ? "" : "s");
  if (faults.mixed_edges)
    return km_fail(error, KM_MODEL,
                   "%s: has %d edge%s between faces that look opposite ways; expected all to look "
                   "outwards",
                   path, faults.mixed_edges, faults.mixed_edges == 1 ? "" : "s");
  return KM_OK;
}

static km_status weigh_mesh(const km_mesh *mesh, const char *path, km_mass_properties *out, km_error *error) {
  km_error local;
  km_status status = check_closed(mesh, path, error);
  if (!status && km_mass_properties_of(mesh, out, &local))
    status = km_fail(error, KM_MODEL, "%s: %.200s; expected a closed surface to go with a density", path, local.text);
  return status;
}

static km_status weigh(const char *path, km_model_body *body, km_error *error) {
  km_mesh *mesh = NULL;
  km_mass_properties found;
  km_status status = km_mesh_read(path, &mesh, error);
  if (!status)
    status = weigh_mesh(mesh, path, &found, error);
  km_mesh_free(mesh);
  if (status)
    return status;
  body->mass = body->density * found.volume;
  body->center_of_mass = found.center;
  for (int k = 0; k < 6; ++k)
    body->inertia[k] = body->density * found.inertia[k];
  return KM_OK;
}

void km_model_weigh(km_model *model, km_messages *messages) {
  km_text path = {0};
  for (int b = 1; b < model->body_count; ++b) {
    km_model_body *body = &model->bodies[b];
    km_error error = {0};
    if (!body->mesh || !(body->density > 0.0))
      continue;
    if (!km_model_find_mesh(model, body->mesh, &path))
      km_messages_add(messages, KM_ERROR, "%s.definition: mesh \"%.200s\" %s; its density needs it", body->where,
                      body->mesh, not_found);
    else if (weigh(path.data, body, &error) == KM_MEMORY)
      model->arena.failed = true;
    else if (error.status)
      km_messages_add(messages, KM_ERROR, "%s.definition: %.900s", body->where, error.text);
  }
  km_text_free(&path);
}

km_status km_model_weigh_meshes(km_model *model, km_error *error) {
  if (!model)
    return km_fail(error, KM_USAGE, "found no model");
  km_messages *messages = km_messages_create();
  if (!model || !messages) {
    km_messages_free(messages);
    return km_fail(error, model ? KM_MEMORY : KM_USAGE, model ? "out of memory for meshes" : "found no model");
  }
  km_model_weigh(model, messages);
  km_status status = model->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for meshes") : KM_OK;
  for (size_t i = 0; i < km_messages_count(messages) && !status; ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      status = km_fail(error, KM_MODEL, "%s", km_messages_text(messages, i));
  km_messages_free(messages);
  return status;
}

void km_model_miss_meshes(const km_model *model, km_messages *messages) {
  const km_model_body *first = NULL;
  int missed = 0;
  km_text path = {0};
  for (int b = 1; b < model->body_count; ++b) {
    const km_model_body *body = &model->bodies[b];
    if (!body->mesh || km_model_find_mesh(model, body->mesh, &path))
      continue;
    first = first ? first : body;
    ++missed;
  }
  km_text_free(&path);
  if (missed == 1)
    km_messages_add(messages, KM_WARNING, "%s.definition: mesh \"%.200s\" %s", first->where, first->mesh, not_found);
  else if (missed)
    km_messages_add(messages, KM_WARNING, "%s.definition: mesh \"%.200s\" %s, nor are the meshes of %d other bodies",
                    first->where, first->mesh, not_found, missed - 1);
}
