/* Mass properties of bodies from their meshes and densities. */
#include "exchange/mesh/shape_meshes.h"
#include "model/geometry/mass_properties.h"

static const char not_found[] = "is found neither beside the file nor in include_dir";

static km_status find_needed(const km_model *model, const char *mesh, km_text *path, km_error *error) {
  if (km_find_mesh(&model->folders, mesh, path))
    return KM_OK;
  if (path->failed)
    return km_fail(error, KM_MEMORY, "out of memory for meshes");
  return km_fail(error, KM_MODEL, "mesh \"%.200s\" %s; its density needs it", mesh, not_found);
}

static km_status weigh_definition(const km_model *model, const km_model_body *body, km_mass *out, km_error *error) {
  km_mesh *mesh = NULL;
  km_text path = {0};
  km_status status = find_needed(model, body->mesh, &path, error);
  if (!status)
    status = km_mesh_read(path.data, &mesh, error);
  if (!status)
    status = km_mesh_weigh(mesh, path.data, out, error);
  km_mesh_free(mesh);
  km_text_free(&path);
  return status;
}

static km_status weigh_shape(const km_model *model, const km_model_shape *shape, km_mass *out, km_error *error) {
  km_mesh *mesh = NULL;
  km_text path = {0};
  if (km_shape_solid(shape, out))
    return KM_OK;
  km_status status = shape->kind == KM_SHAPE_OF_MESH ? find_needed(model, shape->mesh, &path, error) : KM_OK;
  if (!status)
    status = km_shape_mesh(model, shape, &mesh, error);
  if (!status)
    status = km_mesh_weigh(mesh, shape->mesh, out, error);
  km_text_free(&path);
  km_mesh_free(mesh);
  return status;
}

/* Reports a fault at a part of a body; true: there is one. */
static bool is_fault(km_model *model, const char *where, const char *part, km_status status, const km_error *error,
                     km_messages *messages) {
  if (status == KM_MEMORY)
    model->arena.failed = true;
  else if (status)
    km_messages_add(messages, KM_ERROR, "%s%s: %.900s", where, part, error->text);
  return status != KM_OK;
}

/* Adds a part of some density to what a body weighs. */
static void add(km_mass *sum, double density, km_mass part) {
  *sum = km_mass_sum(*sum, km_mass_scaled(density, part));
}

static void weigh_body(km_model *model, int b, int first_shape, km_messages *messages) {
  km_model_body *body = &model->bodies[b];
  km_mass sum = {0}, part;
  km_error error = {0};
  bool weighed = body->mesh && body->density > 0.0, sound = true;
  if (weighed &&
      !is_fault(model, body->where, ".definition", weigh_definition(model, body, &part, &error), &error, messages))
    add(&sum, body->density, part);
  else
    sound = !weighed;
  for (int s = first_shape; s < model->shape_count && model->shapes[s].body == b; ++s) {
    const km_model_shape *shape = &model->shapes[s];
    if (!(shape->density > 0.0))
      continue;
    weighed = true;
    if (is_fault(model, shape->where, "", weigh_shape(model, shape, &part, &error), &error, messages))
      sound = false;
    else
      add(&sum, shape->density, part);
  }
  if (!weighed || !sound)
    return;
  body->mass = sum.mass;
  body->center_of_mass = sum.center;
  for (int k = 0; k < 6; ++k)
    body->inertia[k] = sum.inertia[k];
}

void km_model_weigh(km_model *model, km_messages *messages) {
  int shape = 0;
  for (int b = 1; b < model->body_count; ++b) {
    while (shape < model->shape_count && model->shapes[shape].body < b)
      ++shape;
    weigh_body(model, b, shape, messages);
  }
}

km_status km_model_weigh_meshes(km_model *model, km_error *error) {
  if (!model)
    return km_fail(error, KM_USAGE, "found no model");
  km_messages *messages = km_messages_create();
  if (!messages)
    return km_fail(error, KM_MEMORY, "out of memory for meshes");
  km_model_weigh(model, messages);
  km_status status = model->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for meshes") : KM_OK;
  for (size_t i = 0; i < km_messages_count(messages) && !status; ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      status = km_fail(error, KM_MODEL, "%s", km_messages_text(messages, i));
  km_messages_free(messages);
  return status;
}

bool km_model_miss_meshes(const km_model *model, km_messages *messages) {
  const char *where = NULL, *part = "", *name = "";
  int missed = 0;
  km_text path = {0};
  for (int k = 1; k < model->body_count + model->shape_count; ++k) {
    bool body = k < model->body_count;
    const km_model_shape *shape = body ? NULL : &model->shapes[k - model->body_count];
    const char *mesh = body ? model->bodies[k].mesh : shape->mesh;
    if (!mesh || km_find_mesh(&model->folders, mesh, &path))
      continue;
    if (path.failed)
      break;
    if (missed++ == 0) {
      where = body ? model->bodies[k].where : shape->where;
      part = body ? ".definition" : "";
      name = mesh;
    }
  }
  bool found_out = !path.failed;
  km_text_free(&path);
  if (missed == 1)
    km_messages_add(messages, KM_WARNING, "%s%s: mesh \"%.200s\" %s", where, part, name, not_found);
  else if (missed)
    km_messages_add(messages, KM_WARNING, "%s%s: mesh \"%.200s\" %s, nor are the meshes of %d other bodies", where,
                    part, name, not_found, missed - 1);
  return found_out;
}
