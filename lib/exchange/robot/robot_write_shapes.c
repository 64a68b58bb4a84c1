/* Shapes of bodies in SI units, for writers of robot descriptions. */
#include "exchange/robot/robot_write.h"

#include "exchange/mesh/mesh_folders.h"

static km_model_shape in_metres(km_written *w, const km_model_shape *shape) {
  km_model_shape out = *shape;
  if (out.mesh)
    out.mesh = km_written_mesh(&w->model->folders, w->destination, out.mesh, &w->arena);
  out.pose.p = km_vec3_scale(w->length, shape->pose.p);
  for (int k = 0; k < 3; ++k) {
    out.size[k] *= w->length;
    out.scale[k] *= w->length;
  }
  return out;
}

/* The mesh that a body is defined by, in the body's own frame. */
static km_model_shape definition(km_written *w, int body) {
  km_model_shape shape = {.body = body,
                          .kind = KM_SHAPE_OF_MESH,
                          .mesh = w->model->bodies[body].mesh,
                          .scale = {1, 1, 1},
                          .pose = km_pose_identity(),
                          .color = {0, 0, 0, -1}};
  return in_metres(w, &shape);
}

const km_model_shape *km_written_shapes(km_written *w, int body, int *count) {
  const km_model *m = w->model;
  size_t room = m->bodies[body].mesh != NULL;
  *count = 0;
  for (int s = 0; s < m->shape_count; ++s)
    room += m->shapes[s].body == body;
  km_model_shape *out = room ? KM_ARENA_NEW(&w->arena, km_model_shape, room) : NULL;
  if (!out)
    return NULL;
  if (m->bodies[body].mesh)
    out[(*count)++] = definition(w, body);
  for (int s = 0; s < m->shape_count; ++s)
    if (m->shapes[s].body == body)
      out[(*count)++] = in_metres(w, &m->shapes[s]);
  return out;
}
