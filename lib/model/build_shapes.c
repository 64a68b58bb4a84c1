/* Models by calls: shapes of bodies. */
#include "model/builder.h"

#include <string.h>

const char *km_shape_word(km_shape_kind kind) {
  static const char *const words[KM_SHAPE_KINDS] = {[KM_SHAPE_OF_MESH] = "mesh",
                                                    [KM_SHAPE_BOX] = "box",
                                                    [KM_SHAPE_SPHERE] = "sphere",
                                                    [KM_SHAPE_CYLINDER] = "cylinder",
                                                    [KM_SHAPE_CAPSULE] = "capsule"};
  return words[kind];
}

int km_shape_sizes(km_shape_kind kind) {
  static const int counts[KM_SHAPE_KINDS] = {0, 3, 1, 2, 2};
  return counts[kind];
}

static bool is_sound(const km_shape_def *def) {
  if ((int)def->kind < 0 || def->kind >= KM_SHAPE_KINDS || !km_builder_sane(def->size, 3) ||
      !km_builder_sane(def->scale, 3) || !km_builder_sane(def->T, 3) || !km_builder_sane(def->R, 9) ||
      !km_builder_sane(&def->density, 1) || !km_builder_sane(def->color, 4) || def->density == 0.0)
    return false;
  if (def->kind == KM_SHAPE_OF_MESH)
    return def->mesh && def->mesh[0] && def->scale[0] * def->scale[1] * def->scale[2] != 0.0;
  for (int k = 0; k < km_shape_sizes(def->kind); ++k)
    if (!(def->size[k] > 0.0))
      return false;
  return true;
}

km_status km_model_add_shape(km_builder *b, km_body_id body, const km_shape_def *def, km_error *error) {
  km_error fault;
  double misfit;
  if (!b || !b->model || !def || body.value < 2 || body.value > b->model->body_count)
    return km_fail(error, KM_MODEL, "a shape: found no body of this builder to put it on");
  km_model *m = b->model;
  const char *name = m->bodies[body.value - 1].name;
  if (!is_sound(def))
    return km_fail(
        error, KM_MODEL,
        "a shape of body \"%.80s\": expected a kind with sizes greater than 0 (of a mesh a file and a scale), "
        "and a density greater than 0 or none",
        name);
  km_pose pose = {.p = km_vec3_from_array(def->T)};
  if (km_model_rotation(def->R, &pose.R, &misfit, &fault))
    return km_fail(error, KM_MODEL, "a shape of body \"%.80s\": %s", name, fault.text);
  const char *mesh = km_arena_string(&m->arena, def->kind == KM_SHAPE_OF_MESH ? def->mesh : NULL);
  if (m->arena.failed || !KM_BUILDER_GROW(b, shapes, shape_room, shape_count))
    return km_builder_memory(error);
  int at = m->shape_count++;
  for (; at > 0 && m->shapes[at - 1].body > body.value - 1; --at)
    m->shapes[at] = m->shapes[at - 1];
  m->shapes[at] = (km_model_shape){
      .body = body.value - 1, .kind = def->kind, .mesh = mesh, .where = name, .pose = pose, .density = def->density};
  memcpy(m->shapes[at].scale, def->scale, sizeof def->scale);
  memcpy(m->shapes[at].size, def->size, sizeof def->size);
  memcpy(m->shapes[at].color, def->color, sizeof def->color);
  return KM_OK;
}
