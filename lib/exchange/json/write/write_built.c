/* Models that no JSON text was read for, written in the model format. */
#include "exchange/json/write/write_built.h"

#include "exchange/json/json.h"
#include "exchange/json/json_model.h"
#include "exchange/json/write/convert.h"
#include "model/validation.h"

#include <string.h>

static const double no_limit = 1e30; /* JSON has no infinity */

typedef struct writer {
  const km_model *model;
  km_arena *arena;
} writer;

static void add_numbers(const writer *w, km_value *parent, const char *key, const double *values, size_t count) {
  km_value_numbers(w->arena, parent, key, values, count);
}

static void add_vector(const writer *w, km_value *parent, const char *key, km_vec3 v) {
  if (v.x != 0.0 || v.y != 0.0 || v.z != 0.0)
    add_numbers(w, parent, key, (const double[3]){v.x, v.y, v.z}, 3);
}

/* One number a coordinate; a list where there are several. `first`: that of the first of the joint's coordinates. */
static void add_coordinates(const writer *w, km_value *parent, const char *key, const double *first, int count) {
  double values[KM_MAX_FREEDOM];
  bool some = false;
  for (int k = 0; k < count; ++k) {
    values[k] = *(const double *)((const char *)first + (size_t)k * sizeof(km_model_coordinate));
    some = some || (values[k] != 0.0 && isfinite(values[k]));
    values[k] = fmin(values[k], no_limit);
  }
  if (some && count == 1)
    km_value_number(w->arena, parent, key, values[0]);
  else if (some)
    add_numbers(w, parent, key, values, (size_t)count);
}

static void add_settings(const writer *w, km_value *root) {
  const km_model *m = w->model;
  km_units own = m->units;
  km_value *settings = km_value_add(w->arena, root, "model_parameters", KM_OBJECT);
  km_value_string(w->arena, settings, "version", "1.1");
  km_value *units = km_value_add(w->arena, settings, "units", KM_OBJECT);
  for (int q = 0; q < KM_QUANTITIES; ++q)
    km_value_string(w->arena, units, km_quantity_name((km_quantity)q), (*km_units_slot(&own, (km_quantity)q))->word);
  add_vector(w, settings, "gravity", m->gravity);
  if (m->closure_tolerance_given)
    km_value_number(w->arena, settings, "closure_tolerance", m->closure_tolerance);
  if (m->characteristic_length > 0.0)
    km_value_number(w->arena, settings, "characteristic_length", m->characteristic_length);
  if (m->source)
    km_value_string(w->arena, root, "source", m->source);
}

static void add_frames(const writer *w, km_value *parent, int body) {
  km_value *list = NULL;
  for (int f = 0; f < w->model->frame_count; ++f) {
    const km_model_frame *frame = &w->model->frames[f];
    if (frame->body != body || strcmp(frame->name, "origin") == 0)
      continue;
    list = list ? list : km_value_add(w->arena, parent, "frames", KM_LIST);
    km_value *twin = km_value_add(w->arena, list, NULL, KM_OBJECT);
    double rows[9];
    km_rotation_rows(&frame->pose.R, rows);
    km_value_string(w->arena, twin, "name", frame->name);
    add_vector(w, twin, "T", frame->pose.p);
    km_value *R = km_value_add(w->arena, twin, "R", KM_LIST);
    for (int i = 0; i < 3; ++i)
      add_numbers(w, R, NULL, &rows[3 * i], 3);
  }
}

static void add_shape(const writer *w, km_value *list, const km_model_shape *shape) {
  km_value *twin = km_value_add(w->arena, list, NULL, KM_OBJECT);
  double rows[9];
  if (shape->kind == KM_SHAPE_OF_MESH)
    km_value_string(w->arena, twin, "mesh", shape->mesh);
  else if (shape->kind == KM_SHAPE_SPHERE)
    km_value_number(w->arena, twin, "sphere", shape->size[0]);
  else
    add_numbers(w, twin, km_shape_word(shape->kind), shape->size, (size_t)km_shape_sizes(shape->kind));
  if (shape->scale[0] != 1.0 || shape->scale[1] != 1.0 || shape->scale[2] != 1.0)
    add_numbers(w, twin, "scale", shape->scale, 3);
  add_vector(w, twin, "T", shape->pose.p);
  km_rotation_rows(&shape->pose.R, rows);
  if (rows[0] != 1.0 || rows[4] != 1.0 || rows[8] != 1.0) {
    km_value *R = km_value_add(w->arena, twin, "R", KM_LIST);
    for (int i = 0; i < 3; ++i)
      add_numbers(w, R, NULL, &rows[3 * i], 3);
  }
  if (shape->color[3] >= 0.0)
    add_numbers(w, twin, "color", shape->color, 4);
  if (shape->density > 0.0)
    km_value_number(w->arena, twin, "density", shape->density);
}

static void add_shapes(const writer *w, km_value *parent, int body) {
  km_value *list = NULL;
  for (int s = 0; s < w->model->shape_count; ++s) {
    if (w->model->shapes[s].body != body)
      continue;
    list = list ? list : km_value_add(w->arena, parent, "shapes", KM_LIST);
    add_shape(w, list, &w->model->shapes[s]);
  }
}

static void add_body(const writer *w, km_value *list, int index) {
  static const char *const keys[6] = {"Ixx", "Iyy", "Izz", "Ixy", "Iyz", "Izx"};
  const km_model_body *body = &w->model->bodies[index];
  km_value *twin = km_value_add(w->arena, list, NULL, KM_OBJECT);
  km_value_string(w->arena, twin, "name", body->name);
  km_value_number(w->arena, twin, "mass", body->mass);
  add_vector(w, twin, "center_of_mass", body->center_of_mass);
  km_value *inertia = km_value_add(w->arena, twin, "moment_of_inertia", KM_OBJECT);
  for (int k = 0; k < 6; ++k)
    km_value_number(w->arena, inertia, keys[k], body->inertia[k]);
  if (body->mesh)
    km_value_string(w->arena, km_value_add(w->arena, twin, "definition", KM_LIST), NULL, body->mesh);
  add_shapes(w, twin, index);
  add_frames(w, twin, index);
}

static void add_assembly_path(const writer *w, km_value *path, int assembly) {
  if (assembly == KM_NO_ASSEMBLY)
    return;
  add_assembly_path(w, path, w->model->assemblies[assembly].parent);
  km_value_string(w->arena, path, NULL, w->model->assemblies[assembly].name);
}

static void add_frame_path(const writer *w, km_value *list, int frame) {
  const km_model_frame *f = &w->model->frames[frame];
  km_value *path = km_value_add(w->arena, list, NULL, KM_LIST);
  add_assembly_path(w, path, w->model->bodies[f->body].assembly);
  km_value_string(w->arena, path, NULL, w->model->bodies[f->body].name);
  km_value_string(w->arena, path, NULL, f->name);
}

static void add_limits(const writer *w, km_value *twin, const km_model_joint *joint, const km_model_coordinate *c,
                       int count) {
  const double turn[2] = {0.0, joint->most_turn};
  bool some = false;
  if (joint->type == KM_SPHERICAL && joint->most_turn > 0.0) {
    add_numbers(w, twin, "limits", turn, 2);
    return;
  }
  for (int k = 0; k < count; ++k)
    some = some || isfinite(c[k].low) || isfinite(c[k].high);
  if (!some)
    return;
  km_value *list = count > 1 ? km_value_add(w->arena, twin, "limits", KM_LIST) : NULL;
  for (int k = 0; k < count; ++k) {
    const double range[2] = {fmax(c[k].low, -no_limit), fmin(c[k].high, no_limit)};
    add_numbers(w, count > 1 ? list : twin, count > 1 ? NULL : "limits", range, 2);
  }
}

static bool has_friction(const km_model_coordinate *c, int count) {
  bool some = false;
  for (int k = 0; k < count; ++k)
    some = some || c[k].friction > 0.0;
  return some;
}

static void add_joint(const writer *w, km_value *list, int index) {
  const km_model_joint *joint = &w->model->joints[index];
  const km_model_coordinate *c = &w->model->coordinates[joint->first_coordinate];
  int count = km_model_freedom(w->model, index);
  km_value *twin = km_value_add(w->arena, list, NULL, KM_OBJECT);
  km_value_string(w->arena, twin, "name", joint->name);
  km_value_string(w->arena, twin, "type", km_joint_kind_of(joint->type)->word);
  km_value *pair = km_value_add(w->arena, twin, "body_frame_pairs", KM_LIST);
  add_frame_path(w, pair, joint->frame[0]);
  add_frame_path(w, pair, joint->frame[1]);
  add_coordinates(w, twin, "initial_displacement", &c->position, count);
  add_coordinates(w, twin, "initial_velocity", &c->rate, count);
  add_coordinates(w, twin, "damping", &c->damping, count);
  add_limits(w, twin, joint, c, count);
  add_coordinates(w, twin, "max_rate", &c->max_rate, count);
  add_coordinates(w, twin, "max_force", &c->max_force, count);
  add_coordinates(w, twin, "armature", &c->armature, count);
  if (has_friction(c, count))
    add_coordinates(w, km_value_add(w->arena, twin, "friction", KM_OBJECT), "torque", &c->friction, count);
  if (joint->type == KM_SCREW)
    km_value_number(w->arena, twin, "pitch", joint->pitch);
}

/* The assembly of what names coordinates: that of the first one's joint. */
static int assembly_of(const km_model *m, int coordinate) {
  return m->joints[m->coordinates[coordinate].joint].assembly;
}

static void add_coordinate_path(const writer *w, km_value *parent, const char *key, int coordinate) {
  const km_model *m = w->model;
  const km_model_joint *joint = &m->joints[m->coordinates[coordinate].joint];
  if (km_model_freedom(m, m->coordinates[coordinate].joint) > 1) {
    km_value_string(w->arena, parent, key, m->coordinates[coordinate].label);
    return;
  }
  km_value *path = km_value_add(w->arena, parent, key, KM_LIST);
  add_assembly_path(w, path, joint->assembly);
  km_value_string(w->arena, path, NULL, joint->name);
}

static void add_couplings(const writer *w, km_value *parent, int assembly) {
  km_value *list = NULL;
  for (int i = 0; i < w->model->coupling_count; ++i) {
    const km_model_coupling *coupling = &w->model->couplings[i];
    if (assembly_of(w->model, coupling->coordinates[0]) != assembly)
      continue;
    list = list ? list : km_value_add(w->arena, parent, "couplings", KM_LIST);
    km_value *twin = km_value_add(w->arena, list, NULL, KM_OBJECT);
    km_value_string(w->arena, twin, "name", coupling->name);
    km_value *joints = km_value_add(w->arena, twin, "joints", KM_LIST);
    for (int k = 0; k < coupling->count; ++k)
      add_coordinate_path(w, joints, NULL, coupling->coordinates[k]);
    if (coupling->polynomial_count > 0)
      add_numbers(w, twin, "polynomial", coupling->polynomial, (size_t)coupling->polynomial_count);
    else
      add_numbers(w, twin, "ratios", coupling->ratios, (size_t)coupling->count);
    if (coupling->constant_given)
      km_value_number(w->arena, twin, "constant", coupling->constant);
  }
}

/* Springs in joints: the only force laws that robot descriptions have. */
static void add_springs(const writer *w, km_value *parent, int assembly) {
  km_value *list = NULL;
  for (int i = 0; i < w->model->module_count; ++i) {
    const km_model_module *module = &w->model->modules[i];
    if (!km_module_is_spring_in_joint(module) || assembly_of(w->model, module->input.coordinate) != assembly)
      continue;
    list = list ? list : km_value_add(w->arena, parent, "force_modules", KM_LIST);
    km_value *twin = km_value_add(w->arena, list, NULL, KM_OBJECT);
    km_value_string(w->arena, twin, "name", module->name);
    km_value_string(w->arena, twin, "type", km_module_type_word(module->type));
    km_value *input = km_value_add(w->arena, twin, "input", KM_OBJECT);
    km_value_string(w->arena, input, "type", "joint");
    add_coordinate_path(w, input, "joint", module->input.coordinate);
    add_numbers(w, twin, "knot_points", module->law.knots, (size_t)module->law.knot_count);
    km_value *pieces = km_value_add(w->arena, twin, "coefficients", KM_LIST);
    for (int k = 0; k <= module->law.knot_count; ++k)
      add_numbers(w, pieces, NULL, module->law.coefficients + module->law.start[k],
                  (size_t)(module->law.start[k + 1] - module->law.start[k]));
  }
}

static void add_assemblies(const writer *w, km_value *parent, int around) {
  const km_model *m = w->model;
  km_value *list = NULL;
  for (int a = 0; a < m->assembly_count; ++a) {
    if (m->assemblies[a].parent != around)
      continue;
    list = list ? list : km_value_add(w->arena, parent, "assemblies", KM_LIST);
    km_value *twin = km_value_add(w->arena, list, NULL, KM_OBJECT);
    km_value_string(w->arena, twin, "name", m->assemblies[a].name);
    km_value *bodies = km_value_add(w->arena, twin, "bodies", KM_LIST);
    for (int b = 1; b < m->body_count; ++b)
      if (m->bodies[b].assembly == a)
        add_body(w, bodies, b);
    km_value *joints = km_value_add(w->arena, twin, "joints", KM_LIST);
    for (int j = 0; j < m->joint_count; ++j)
      if (m->joints[j].assembly == a)
        add_joint(w, joints, j);
    add_couplings(w, twin, a);
    add_springs(w, twin, a);
    add_assemblies(w, twin, a);
  }
}

static void add_poses(const writer *w, km_value *root) {
  const km_model *m = w->model;
  km_value *poses = m->pose_count ? km_value_add(w->arena, root, "poses", KM_OBJECT) : NULL;
  for (int i = 0; i < m->pose_count; ++i) {
    km_value *pose = km_value_add(w->arena, poses, m->poses[i].name, KM_OBJECT);
    for (int k = 0; k < m->poses[i].count; ++k)
      km_value_number(w->arena, pose, m->coordinates[m->poses[i].coordinates[k]].label, m->poses[i].values[k]);
  }
}

const km_value *km_built_tree(const km_model *model, km_arena *arena) {
  writer w = {model, arena};
  km_value *root = km_value_add(arena, NULL, NULL, KM_OBJECT);
  if (!root)
    return NULL;
  add_settings(&w, root);
  km_value *fixed = km_value_add(arena, root, "fixed", KM_OBJECT);
  add_frames(&w, fixed, 0);
  add_assemblies(&w, root, KM_NO_ASSEMBLY);
  add_poses(&w, root);
  if (model->actuator_count > 0) {
    km_value *analysis = km_value_add(arena, root, "analysis", KM_OBJECT);
    km_value *actuators = km_value_add(arena, analysis, "actuators", KM_LIST);
    for (int i = 0; i < model->actuator_count; ++i)
      add_coordinate_path(&w, actuators, NULL, model->actuators[i]);
  }
  return root;
}

/* The coordinates in the order of the model read back. */
static double *reorder(const km_model *model, const km_model *twin, const double *q, km_arena *arena) {
  km_names labels = {0};
  double *out = KM_ARENA_NEW(arena, double, (size_t)twin->coordinate_count);
  for (int c = 0; c < model->coordinate_count; ++c)
    if (!km_names_set(&labels, 0, model->coordinates[c].label, c))
      arena->failed = true;
  for (int c = 0; out && !arena->failed && c < twin->coordinate_count; ++c)
    out[c] = q[km_names_get(&labels, 0, twin->coordinates[c].label)];
  km_names_free(&labels);
  return out;
}

km_status km_built_convert(const km_model *model, const km_units *units, const double *q, bool frames, km_arena *arena,
                           const km_value **out, km_error *error) {
  km_text text = {0};
  km_arena own = {0};
  km_model *twin = NULL;
  km_messages *messages = km_messages_create();
  const km_value *tree = km_built_tree(model, &own);
  km_status status = KM_MEMORY;
  if (tree && !own.failed && messages) {
    km_json_write(tree, &text);
    status = text.failed ? KM_MEMORY : km_json_model(text.data, text.size, &(km_read_def){0}, messages, &twin, error);
  }
  const double *moved = !status && q ? reorder(model, twin, q, &own) : NULL;
  if (!status && !own.failed)
    status = km_model_convert(twin, units, moved, frames, arena, out, error); /* it keeps nothing of the twin */
  if (status == KM_MEMORY || own.failed)
    status = km_fail(error, KM_MEMORY, "out of memory while converting the model");
  km_text_free(&text);
  km_messages_free(messages);
  km_model_free(twin);
  km_arena_free(&own);
  return status;
}
