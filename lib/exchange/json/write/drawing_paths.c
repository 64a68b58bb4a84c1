/* Paths to frames in a model that becomes a drawing, where bodies lose the frames of their own. */
#include "model/name_path.h"
#include "exchange/json/write/drawing_tree.h"

#include <string.h>

static int body_named(const km_model *model, int assembly, const char *name) {
  for (int b = 1; b < model->body_count; ++b)
    if (model->bodies[b].assembly == assembly && strcmp(model->bodies[b].name, name) == 0)
      return b;
  return -1;
}

static int frame_named(const km_model *model, int body, const char *name) {
  for (int f = 0; f < model->frame_count && body >= 0; ++f)
    if (model->frames[f].body == body && strcmp(model->frames[f].name, name) == 0)
      return f;
  return -1;
}

static int assembly_named(const km_model *model, int around, const char *name) {
  for (int a = 0; a < model->assembly_count; ++a)
    if (model->assemblies[a].parent == around && strcmp(model->assemblies[a].name, name) == 0)
      return a;
  return -1;
}

static int body_from_root(const km_model *model, const char *const *names, size_t count) {
  int assembly = KM_NO_ASSEMBLY;
  for (size_t i = 0; i + 1 < count; ++i) {
    assembly = assembly_named(model, assembly, names[i]);
    if (assembly < 0)
      return -1;
  }
  return count < 2 ? -1 : body_named(model, assembly, names[count - 1]);
}

/* The readings of a path, in the reader's order: one that names a frame wins. */
static int frame_of(const km_model *model, int assembly, const char *const *names, size_t count) {
  if (strcmp(names[0], "fixed") == 0 && count <= 2)
    return frame_named(model, 0, count == 2 ? names[1] : "origin");
  int frame = -1;
  if (count == 2)
    frame = frame_named(model, body_named(model, assembly, names[0]), names[1]);
  else if (count > 2)
    frame = frame_named(model, body_from_root(model, names, count - 1), names[count - 1]);
  if (frame >= 0)
    return frame;
  int body = count == 1 ? body_named(model, assembly, names[0]) : body_from_root(model, names, count);
  return frame_named(model, body, "origin");
}

/* [body, frame] is valid in `analysis`, too, if the body's name is unique. */
static int frame_anywhere(const km_model *model, int assembly, const char *const *names, size_t count) {
  int frame = frame_of(model, assembly, names, count);
  for (int a = 0; a < model->assembly_count && frame < 0 && assembly == KM_NO_ASSEMBLY && count <= 2; ++a)
    frame = frame_of(model, a, names, count);
  return frame;
}

int km_sketch_frame(const km_sketch *s, int assembly, const km_value *path) {
  km_path_names p;
  int frame = -1;
  if (!km_path_names_gather(path, &p))
    return -1;
  frame = frame_anywhere(s->model, assembly, p.names, p.count);
  if (frame < 0 && p.count == 1 && km_path_names_split(p.names[0], &p))
    frame = frame_anywhere(s->model, assembly, p.names, p.count);
  km_path_names_free(&p);
  s->arena->failed = s->arena->failed || p.failed;
  return frame;
}

bool km_names_frame(const km_field *field) {
  static const char *const keys[] = {"frame", "from", "to", "parent"};
  bool found = false;
  for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i)
    found = found || strcmp(field->key, keys[i]) == 0;
  return field->shape == KM_SHAPE_PATH && found;
}

bool km_names_frames(const km_field *field) {
  return field->shape == KM_SHAPE_PATH_PAIR;
}

int km_sketch_assembly(const km_sketch *s, int around, const km_value *object) {
  const km_value *name = km_value_get(object, "name");
  return km_reader_active(object) && name && name->string ? assembly_named(s->model, around, name->string) : -1;
}

static int joint_of(const km_sketch *s, const km_value *object) {
  for (int j = 0; j < s->model->joint_count; ++j)
    if (s->model->origin->joints[j] == object)
      return j;
  return -1;
}

static void each_path(km_sketch *s, const km_object_format *format, const km_value *object, int assembly,
                      km_sketch_path found);

static void each_in_field(km_sketch *s, const km_field *field, const km_value *value, int assembly,
                          km_sketch_path found) {
  if (km_names_frame(field))
    found(s, km_sketch_frame(s, assembly, value));
  for (const km_value *v = km_names_frames(field) ? value->first : NULL; v; v = v->next)
    found(s, km_sketch_frame(s, assembly, v));
  if (field->object && value->kind == KM_OBJECT)
    each_path(s, field->object, value, assembly, found);
  for (const km_value *v = field->shape == KM_SHAPE_OBJECTS ? value->first : NULL; v; v = v->next)
    each_path(s, field->object, v, assembly, found);
}

static void each_path(km_sketch *s, const km_object_format *format, const km_value *object, int assembly,
                      km_sketch_path found) {
  if (format == &km_format_assembly)
    assembly = km_sketch_assembly(s, assembly, object);
  int joint = format == &km_format_joint ? joint_of(s, object) : -1;
  bool gone = (format == &km_format_assembly && assembly < 0) || (joint >= 0 && s->pointed[joint]);
  for (const km_value *v = object->first; v && !gone; v = v->next) {
    const km_field *field = km_format_field(format, v->key);
    if (field)
      each_in_field(s, field, v, assembly, found);
  }
}

void km_sketch_each_path(km_sketch *s, const km_value *root, km_sketch_path found) {
  each_path(s, &km_format_model, root, KM_NO_ASSEMBLY, found);
}

void km_sketch_write_assemblies(const km_sketch *s, int assembly, km_value *path) {
  if (assembly == KM_NO_ASSEMBLY)
    return;
  km_sketch_write_assemblies(s, s->model->assemblies[assembly].parent, path);
  km_value_string(s->arena, path, NULL, s->model->assemblies[assembly].name);
}

void km_sketch_write_path(const km_sketch *s, int assembly, const km_value *path, km_value *parent, const char *key) {
  int frame = km_sketch_frame(s, assembly, path);
  int body = frame < 0 ? 0 : s->model->frames[frame].body;
  if (!s->own[body] || strcmp(s->model->frames[frame].name, "origin") != 0) {
    km_sketch_copy(s, path, parent, key);
    return;
  }
  km_value *names = km_value_add(s->arena, parent, key, KM_LIST);
  if (s->model->bodies[body].assembly != assembly)
    km_sketch_write_assemblies(s, s->model->bodies[body].assembly, names);
  km_value_string(s->arena, names, NULL, s->model->bodies[body].name);
  km_value_string(s->arena, names, NULL, s->own[body]);
}
