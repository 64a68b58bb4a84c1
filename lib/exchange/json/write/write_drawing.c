/* Writing a model as drawings: which assemblies and joints can be drawn, and the tree around them. */
#include "exchange/json/write/convert.h"

#include "exchange/json/json.h"
#include "exchange/json/json_model.h"
#include "exchange/json/write/convert_drawn.h"
#include "exchange/json/write/drawing_tree.h"
#include "model/initial_poses.h"

#include <string.h>

void km_sketch_copy(const km_sketch *s, const km_value *value, km_value *parent, const char *key) {
  km_value *twin = km_value_add(s->arena, parent, key, value->kind);
  if (!twin)
    return;
  twin->number = value->number;
  twin->string = km_arena_string(s->arena, value->string);
  for (const km_value *v = value->first; v; v = v->next)
    km_sketch_copy(s, v, twin, v->key);
}

/* A mesh becomes a shape, which has no place for a material. */
static bool mesh_stays(const km_sketch *s, int body) {
  const km_value *object = s->model->origin->bodies[body], *definition = km_value_get(object, "definition");
  return !definition || definition->count < 2 || km_sketch_stays(s, body);
}

static const char *left_out_body(const km_value *assembly) {
  const km_value *bodies = km_value_get(assembly, "bodies");
  for (const km_value *v = bodies ? bodies->first : NULL; v; v = v->next)
    if (!km_reader_active(v))
      return km_value_get(v, "name")->string;
  return NULL;
}

/* Adds a note with the reason why an assembly keeps its frames. */
static bool can_draw(const km_sketch *s, int assembly, const km_value *object, km_messages *notes) {
  const char *name = s->model->assemblies[assembly].name, *gone = left_out_body(object);
  if (gone) {
    km_messages_add(notes, KM_NOTE,
                    "assembly \"%.80s\" keeps its frames: where its body \"%.80s\" stands, which is left "
                    "out, isn't known",
                    name, gone);
    return false;
  }
  for (int b = 1; b < s->model->body_count; ++b)
    if (s->model->bodies[b].assembly == assembly && !mesh_stays(s, b)) {
      km_messages_add(notes, KM_NOTE,
                      "assembly \"%.80s\" keeps its frames: the mesh of its body \"%.80s\" has a material and "
                      "would have to be moved",
                      name, s->model->bodies[b].name);
      return false;
    }
  return true;
}

/* Returns how many assemblies can be drawn. */
static int choose_assemblies(km_sketch *s, const km_value *object, int around, km_messages *notes) {
  const km_value *list = km_value_get(object, "assemblies");
  int count = 0;
  for (const km_value *v = list ? list->first : NULL; v; v = v->next) {
    int assembly = km_sketch_assembly(s, around, v);
    if (assembly < 0)
      continue;
    s->drawn[assembly] = can_draw(s, assembly, v, notes);
    count += s->drawn[assembly] + choose_assemblies(s, v, assembly, notes);
  }
  return count;
}

/* Writes joints of drawn bodies by a point, if that defines them; otherwise adds a note. */
static void choose_joints(km_sketch *s, km_messages *notes) {
  const km_model *m = s->model;
  km_text others = {0};
  for (int j = 0; j < m->joint_count; ++j) {
    const km_model_joint *def = &m->joints[j];
    bool drawn = m->origin->joints[j] && s->drawn[def->assembly];
    for (int end = 0; end < 2; ++end)
      drawn = drawn && km_sketch_has_body(s, m->frames[def->frame[end]].body);
    s->pointed[j] = drawn && km_sketch_can_point(s, j);
    if (drawn && !s->pointed[j])
      km_text_format(&others, "%s%s", others.size ? ", " : "", def->label);
  }
  if (others.size)
    km_messages_add(
        notes, KM_NOTE,
        "%s: a pair of frames stays, since a point and an axis don't tell the directions of the coordinates",
        others.data);
  s->arena->failed = s->arena->failed || others.failed;
  km_text_free(&others);
}

static void need(km_sketch *s, int frame) {
  if (frame >= 0)
    s->needed[frame] = true;
}

/* A body whose own frame is named gets a frame there: its origin becomes that of the drawing. */
static void name_own_frames(km_sketch *s) {
  const km_model *m = s->model;
  km_names taken = {0};
  for (int f = 0; f < m->frame_count; ++f)
    if (!km_names_set(&taken, m->frames[f].body, m->frames[f].name, f))
      s->arena->failed = true;
  for (int f = 0; f < m->frame_count; ++f) {
    int body = m->frames[f].body;
    if (!s->needed[f] || body == 0 || !km_sketch_has_body(s, body) || strcmp(m->frames[f].name, "origin") != 0)
      continue;
    const char *name = "body";
    while (km_names_get(&taken, body, name) >= 0 && !s->arena->failed) {
      km_text longer = {0};
      km_text_format(&longer, "%s:", name);
      name = km_text_move_to_arena(&longer, s->arena);
    }
    s->own[body] = name;
  }
  km_names_free(&taken);
}

static void write_object(const km_sketch *s, const km_object_format *format, const km_value *object, int assembly,
                         km_value *parent, const char *key);

static void write_field(const km_sketch *s, const km_field *field, const km_value *value, int assembly,
                        km_value *parent) {
  if (field && km_names_frame(field)) {
    km_sketch_write_path(s, assembly, value, parent, value->key);
  } else if (field && (km_names_frames(field) || field->shape == KM_SHAPE_OBJECTS)) {
    km_value *list = km_value_add(s->arena, parent, value->key, KM_LIST);
    for (const km_value *v = value->first; v; v = v->next) {
      if (field->shape == KM_SHAPE_OBJECTS)
        write_object(s, field->object, v, assembly, list, NULL);
      else
        km_sketch_write_path(s, assembly, v, list, NULL);
    }
  } else if (field && field->object && value->kind == KM_OBJECT) {
    write_object(s, field->object, value, assembly, parent, value->key);
  } else {
    km_sketch_copy(s, value, parent, value->key);
  }
}

static int element_of(const km_value *const *sources, int count, const km_value *object) {
  for (int i = 0; i < count; ++i)
    if (sources[i] == object)
      return i;
  return -1;
}

static void write_object(const km_sketch *s, const km_object_format *format, const km_value *object, int assembly,
                         km_value *parent, const char *key) {
  const struct km_origin *origin = s->model->origin;
  int body = format == &km_format_fixed ? 0 : -1, joint = -1;
  if (format == &km_format_body)
    body = element_of(origin->bodies, s->model->body_count, object);
  if (format == &km_format_joint)
    joint = element_of(origin->joints, s->model->joint_count, object);
  if (body >= 0 && km_sketch_has_body(s, body)) {
    km_sketch_body(s, body, object, parent, key);
  } else if (joint >= 0 && s->pointed[joint]) {
    km_sketch_joint(s, joint, object, parent);
  } else {
    km_value *twin = km_value_add(s->arena, parent, key, KM_OBJECT);
    if (format == &km_format_assembly)
      assembly = km_sketch_assembly(s, assembly, object);
    for (const km_value *v = object->first; v && twin; v = v->next) {
      bool version = format == &km_format_parameters && strcmp(v->key, "version") == 0;
      if (version)
        km_value_string(s->arena, twin, v->key, "1.1");
      else
        write_field(s, km_format_field(format, v->key), v, assembly, twin);
      if (format == &km_format_assembly && assembly >= 0 && s->drawn[assembly] && strcmp(v->key, "name") == 0)
        km_value_string(s->arena, twin, "drawn", "assembled");
    }
  }
}

/* A power of ten below 1e-14 of the largest coordinate of a frame. */
static double grain_of(const km_sketch *s) {
  double largest = 0.0;
  for (int f = 0; f < s->model->frame_count; ++f) {
    const km_model_frame *frame = &s->model->frames[f];
    km_vec3 p = km_pose_point(&s->stand[frame->body], frame->pose.p);
    largest = fmax(largest, fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))));
  }
  return largest > 0.0 ? pow(10.0, floor(log10(1e-14 * largest))) : 1.0;
}

/* The twin is a model with frames, which were read from `root`. */
static km_status draw(const km_model *twin, km_messages *notes, km_arena *own, km_arena *arena, const km_value **out,
                      km_error *error) {
  km_sketch s = {.model = twin,
                 .stand = KM_ARENA_NEW(own, km_pose, (size_t)twin->body_count),
                 .drawn = KM_ARENA_NEW(own, bool, (size_t)twin->assembly_count),
                 .pointed = KM_ARENA_NEW(own, bool, (size_t)twin->joint_count),
                 .needed = KM_ARENA_NEW(own, bool, (size_t)twin->frame_count),
                 .own = KM_ARENA_NEW(own, const char *, (size_t)twin->body_count),
                 .arena = arena};
  if (own->failed || !km_model_start_poses(twin, s.stand))
    return KM_MEMORY;
  s.grain = grain_of(&s);
  if (choose_assemblies(&s, twin->origin->root, KM_NO_ASSEMBLY, notes) == 0)
    return km_fail(error, KM_NO_RESULT, "no assembly can be drawn%s",
                   twin->assembly_count ? ", as the notes tell" : ": the model has none");
  choose_joints(&s, notes);
  km_sketch_each_path(&s, twin->origin->root, need);
  name_own_frames(&s);
  km_value *root = km_value_add(arena, NULL, NULL, KM_OBJECT);
  for (const km_value *v = twin->origin->root->first; v && root; v = v->next)
    write_field(&s, km_format_field(&km_format_model, v->key), v, KM_NO_ASSEMBLY, root);
  *out = root;
  return arena->failed ? KM_MEMORY : KM_OK;
}

/* The model with frames in the given configuration and units, read again: the configuration is that of its initial
 * displacements. */
static km_status read_twin(const km_model *model, const km_units *units, const double *q, km_arena *own,
                           km_model **twin, km_error *error) {
  km_text text = {0}, file = {0};
  const km_value *tree;
  km_messages *messages = km_messages_create();
  km_status status = messages ? km_model_convert(model, units, q, true, own, &tree, error) : KM_MEMORY;
  if (!status) {
    km_json_write(tree, &text);
    km_text_format(&file, "%s/model", model->folders.folder ? model->folders.folder : ".");
    status = text.failed || file.failed
                 ? KM_MEMORY
                 : km_json_model(text.data, text.size, &(km_read_def){.file = file.data}, messages, twin, error);
  }
  km_text_free(&text);
  km_text_free(&file);
  km_messages_free(messages);
  return status;
}

/* True if every assembly of the file is already drawn in this configuration. */
static bool is_drawn(const km_model *model, const double *q) {
  bool drawn = model->origin && model->assembly_count > 0 && !(q && km_drawing_moved(model, q));
  for (int a = 0; a < model->assembly_count; ++a)
    drawn = drawn && model->assemblies[a].drawn;
  return drawn;
}

km_status km_model_draw(const km_model *model, const km_units *units, const double *q, km_messages *notes,
                        km_arena *arena, const km_value **out, km_error *error) {
  km_status sound = km_check_convert(model, units, q, arena, out, error);
  if (sound)
    return sound;
  if (is_drawn(model, q))
    return km_model_convert(model, units, q, false, arena, out, error);
  km_arena own = {0};
  km_model *twin = NULL;
  km_status status = read_twin(model, units, q, &own, &twin, error);
  if (!status)
    status = draw(twin, notes, &own, arena, out, error);
  if (status == KM_MEMORY)
    status = km_fail(error, KM_MEMORY, "out of memory while drawing the model");
  km_model_free(twin);
  km_arena_free(&own);
  return status;
}
