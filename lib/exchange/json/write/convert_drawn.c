/* Converts drawn joints to frames and pairs of frames. */
#include "exchange/json/write/convert_drawn.h"

#include "exchange/json/read/reader.h"

#include <string.h>

bool km_joint_in_drawing(const km_model *model, int joint) {
  return model->assemblies[model->joints[joint].assembly].drawn;
}

static bool is_pointed(const km_model *model, int joint) {
  const km_value *source = model->origin->joints[joint];
  return source && km_joint_is_drawn(source);
}

bool km_drawing_moved(const km_model *model, const double *q) {
  double size = 0.0;
  for (int f = 0; f < model->frame_count; ++f)
    size = fmax(size, km_vec3_norm(model->frames[f].pose.p));
  for (int c = 0; c < model->coordinate_count; ++c) {
    const km_model_coordinate *def = &model->coordinates[c];
    bool length = km_model_coordinate_is_length(model, c);
    double unit = length ? size : 1.0 / model->units.angle->si;
    if (km_joint_in_drawing(model, def->joint) && fabs(q[c] - def->position) > 1e-9 * unit)
      return true;
  }
  return false;
}

static void write_frame(const km_model_frame *frame, double factor, km_arena *arena, km_value *frames) {
  km_value *out = km_value_add(arena, frames, NULL, KM_OBJECT);
  const km_vec3 *axis = frame->pose.R.axis;
  const km_rotation identity = km_rotation_identity();
  const double T[3] = {factor * frame->pose.p.x, factor * frame->pose.p.y, factor * frame->pose.p.z};
  const double R[3][3] = {
      {axis[0].x, axis[1].x, axis[2].x}, {axis[0].y, axis[1].y, axis[2].y}, {axis[0].z, axis[1].z, axis[2].z}};
  if (!out)
    return;
  km_value_string(arena, out, "name", frame->name);
  km_value_numbers(arena, out, "T", T, 3);
  if (memcmp(axis, identity.axis, sizeof identity.axis) == 0)
    return;
  km_value *rows = km_value_add(arena, out, "R", KM_LIST);
  for (int i = 0; i < 3 && rows; ++i)
    km_value_numbers(arena, rows, NULL, R[i], 3);
}

void km_write_drawn_frames(const km_model *model, int body, double factor, km_arena *arena, km_value *object) {
  km_value *frames = (km_value *)km_value_get(object, "frames");
  for (int j = 0; j < model->joint_count && !arena->failed; ++j)
    for (int end = 0; end < 2 && is_pointed(model, j); ++end) {
      const km_model_frame *frame = &model->frames[model->joints[j].frame[end]];
      if (frame->body != body)
        continue;
      if (!frames)
        frames = km_value_add(arena, object, "frames", KM_LIST);
      if (frames)
        write_frame(frame, factor, arena, frames);
    }
}

static void write_assemblies(const km_model *model, int assembly, km_arena *arena, km_value *path) {
  if (assembly == KM_NO_ASSEMBLY)
    return;
  write_assemblies(model, model->assemblies[assembly].parent, arena, path);
  km_value_string(arena, path, NULL, model->assemblies[assembly].name);
}

void km_write_drawn_pair(const km_model *model, int joint, km_arena *arena, km_value *object) {
  km_value *pair = km_value_add(arena, object, "body_frame_pairs", KM_LIST);
  for (int end = 0; end < 2; ++end) {
    const km_model_frame *frame = &model->frames[model->joints[joint].frame[end]];
    const km_model_body *body = &model->bodies[frame->body];
    km_value *path = pair ? km_value_add(arena, pair, NULL, KM_LIST) : NULL;
    if (!path)
      return;
    if (body->assembly != model->joints[joint].assembly)
      write_assemblies(model, body->assembly, arena, path);
    km_value_string(arena, path, NULL, body->name);
    km_value_string(arena, path, NULL, frame->name);
  }
}
