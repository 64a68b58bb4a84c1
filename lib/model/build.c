/* Models by calls: settings, assemblies, bodies, frames. */
#include "model/builder.h"

#include <string.h>

static const double largest_number = 1e60; /* limit of magnitude, as in files: a product of a few larger numbers
                                            * overflows */

km_status km_builder_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory while building the model");
}

bool km_builder_sane(const double *values, size_t count) {
  for (size_t i = 0; i < count; ++i)
    if (!(fabs(values[i]) <= largest_number))
      return false;
  return true;
}

static km_status insane(const char *kind, const char *name, km_error *error) {
  return km_fail(error, KM_MODEL, "%s \"%.80s\": found a number that is not finite; expected magnitudes up to 1e60",
                 kind, name);
}

double *km_builder_numbers(km_builder *b, const double *values, size_t count) {
  double *copy = count ? KM_ARENA_NEW(&b->model->arena, double, count) : NULL;
  if (copy)
    memcpy(copy, values, count * sizeof *copy);
  return copy;
}

km_status km_builder_name(km_builder *b, const char *kind, const char *name, const km_names *names, int scope,
                          const char *reserved, const char **out, km_error *error) {
  if (!name || !name[0])
    return km_fail(error, KM_MODEL, "found a %s with an empty name; expected at least one character", kind);
  if (reserved && strcmp(name, reserved) == 0)
    return km_fail(error, KM_MODEL, "%s \"%s\": this name is reserved; expected another one", kind, name);
  if (names && km_names_get(names, scope, name) >= 0)
    return km_fail(error, KM_MODEL, "%s \"%.80s\": this name is used twice here; expected a name of its own", kind,
                   name);
  *out = km_arena_string(&b->model->arena, name);
  return *out ? KM_OK : km_builder_memory(error);
}

bool km_builder_frame(const km_builder *b, km_frame_id id, const char *who, int *out, km_error *error) {
  *out = id.value - 1;
  if (*out >= 0 && *out < b->model->frame_count)
    return true;
  km_fail(error, KM_MODEL, "%.80s: found %s; expected the id of a frame of this builder", who,
          id.value ? "an id that no frame has" : "no frame");
  return false;
}

bool km_builder_coordinate(const km_builder *b, km_coordinate_ref ref, const char *who, int *out, km_error *error) {
  int joint = ref.joint.value - 1;
  if (joint < 0 || joint >= b->model->joint_count) {
    km_fail(error, KM_MODEL, "%.80s: found %s; expected the id of a joint of this builder", who,
            ref.joint.value ? "an id that no joint has" : "no joint");
    return false;
  }
  int freedom = km_model_freedom(b->model, joint);
  if (ref.index < 0 || ref.index >= freedom) {
    km_fail(error, KM_MODEL, "%.80s: found coordinate %d of joint \"%.80s\"; expected one of its %d", who, ref.index,
            b->model->joints[joint].name, freedom);
    return false;
  }
  *out = b->model->joints[joint].first_coordinate + ref.index;
  return true;
}

static bool add_frame(km_builder *b, int body, const char *name, km_pose pose) {
  km_model *m = b->model;
  if (!KM_BUILDER_GROW(b, frames, frame_room, frame_count) || !km_names_set(&b->frames, body, name, m->frame_count))
    return false;
  m->frames[m->frame_count++] = (km_model_frame){name, body, pose};
  return true;
}

static bool add_body(km_builder *b, km_model_body body) {
  km_model *m = b->model;
  if (!KM_BUILDER_GROW(b, bodies, body_room, body_count) ||
      !km_names_set(&b->bodies, body.assembly, body.name, m->body_count) ||
      !add_frame(b, m->body_count, "origin", km_pose_identity()))
    return false;
  m->bodies[m->body_count++] = body;
  return true;
}

/* Creates a model with the inertial frame only. */
static bool begin(km_builder *b) {
  *b = (km_builder){.model = KM_NEW(km_model, 1)};
  if (!b->model)
    return false;
  km_model *m = b->model;
  m->folders.folder = ".";
  m->units = km_units_default();
  m->closure_tolerance = 1e-9;
  m->sweep = (km_model_sweep){.coordinate = -1, .direction = -1, .sign = 1.0, .steps = 100};
  m->advantage_input = m->advantage_output = (km_model_port){-1, -1, {0, 0, 0}, NULL};
  memcpy(m->sha256, "", 1);
  return add_body(b, (km_model_body){.name = "fixed", .assembly = KM_NO_ASSEMBLY, .where = "fixed", .density = -1.0});
}

static void forget(km_builder *b) {
  km_names_free(&b->assemblies);
  km_names_free(&b->bodies);
  km_names_free(&b->frames);
  km_names_free(&b->joints);
  km_model_free(b->model);
  b->model = NULL;
}

km_status km_builder_create(km_builder **out, km_error *error) {
  if (!out)
    return km_fail(error, KM_USAGE, "found no place for the builder");
  *out = KM_NEW(km_builder, 1);
  if (*out && begin(*out))
    return KM_OK;
  km_builder_free(*out);
  *out = NULL;
  return km_builder_memory(error);
}

void km_builder_free(km_builder *b) {
  if (b)
    forget(b);
  km_free(b);
}

km_body_id km_builder_fixed(const km_builder *b) {
  return (km_body_id){b && b->model};
}

km_frame_id km_builder_origin(const km_builder *b, km_body_id body) {
  if (!b || !b->model || body.value < 1 || body.value > b->model->body_count)
    return (km_frame_id){0};
  return (km_frame_id){km_names_get(&b->frames, body.value - 1, "origin") + 1};
}

static km_status set_units(km_units *units, const km_settings_def *def, km_error *error) {
  const char *const words[KM_QUANTITIES] = {def->angle, def->length, def->mass, def->time, def->force};
  for (int q = 0; q < KM_QUANTITIES; ++q) {
    const km_unit *unit = words[q] ? km_unit_find((km_quantity)q, words[q]) : NULL;
    if (!unit)
      return km_fail(error, KM_MODEL, "\"%.60s\" is not a unit of %s; expected one of the format's",
                     words[q] ? words[q] : "", km_quantity_name((km_quantity)q));
    *km_units_slot(units, (km_quantity)q) = unit;
  }
  return KM_OK;
}

km_status km_model_set(km_builder *b, const km_settings_def *def, km_error *error) {
  if (!b || !b->model || !def)
    return km_fail(error, KM_USAGE, "found no builder or no settings");
  km_units units = b->model->units;
  km_status status = set_units(&units, def, error);
  if (status)
    return status;
  if (!km_builder_sane(def->gravity, 3) ||
      !(def->characteristic_length == 0.0 || def->characteristic_length > 1e-100) ||
      !(def->closure_tolerance >= 0.0 && def->closure_tolerance < 0.1))
    return km_fail(error, KM_MODEL,
                   "found a gravity that is not finite, a characteristic length below 0 or a closure tolerance "
                   "outside 0 to 0.1");
  const char *source = def->source ? km_arena_string(&b->model->arena, def->source) : NULL;
  if (def->source && !source)
    return km_builder_memory(error);
  b->model->units = units;
  b->model->gravity = km_vec3_from_array(def->gravity);
  b->model->characteristic_length = def->characteristic_length;
  b->model->closure_tolerance_given = def->closure_tolerance > 0.0;
  b->model->closure_tolerance = def->closure_tolerance > 0.0 ? def->closure_tolerance : 1e-9;
  b->model->source = source;
  return KM_OK;
}

km_status km_model_add_assembly(km_builder *b, const char *name, km_assembly_id parent, km_assembly_id *out,
                                km_error *error) {
  const char *copy;
  if (!b || !b->model || parent.value < 0 || parent.value > b->model->assembly_count)
    return km_fail(error, KM_MODEL, "assembly \"%.80s\": found a parent that is none of this builder",
                   name ? name : "");
  int scope = parent.value ? parent.value - 1 : KM_NO_ASSEMBLY;
  km_status status = km_builder_name(b, "assembly", name, &b->assemblies, scope, "fixed", &copy, error);
  if (status)
    return status;
  km_model *m = b->model;
  if (!KM_BUILDER_GROW(b, assemblies, assembly_room, assembly_count) ||
      !km_names_set(&b->assemblies, scope, copy, m->assembly_count))
    return km_builder_memory(error);
  m->assemblies[m->assembly_count++] = (km_model_assembly){copy, scope, false};
  if (out)
    out->value = m->assembly_count;
  return KM_OK;
}

km_status km_builder_assembly(km_builder *b, km_assembly_id id, int *out, km_error *error) {
  if (id.value < 0 || id.value > b->model->assembly_count)
    return km_fail(error, KM_MODEL, "found an assembly that is none of this builder");
  if (id.value == 0 && b->model->assembly_count == 0) {
    km_status status = km_model_add_assembly(b, "model", (km_assembly_id){0}, NULL, error);
    if (status)
      return status;
  }
  *out = id.value ? id.value - 1 : 0;
  return KM_OK;
}

km_status km_model_add_body(km_builder *b, const km_body_def *def, km_body_id *out, km_error *error) {
  int assembly;
  if (!b || !b->model || !def)
    return km_fail(error, KM_USAGE, "found no builder or no definition of a body");
  km_status status = km_builder_assembly(b, def->assembly, &assembly, error);
  const char *name;
  if (!status)
    status = km_builder_name(b, "body", def->name, &b->bodies, assembly, "fixed", &name, error);
  if (status)
    return status;
  if (!km_builder_sane(&def->mass, 1) || !km_builder_sane(def->center_of_mass, 3) ||
      !km_builder_sane(def->inertia, 6) || !km_builder_sane(&def->density, 1))
    return insane("body", name, error);
  if (def->mass < 0.0)
    return km_fail(error, KM_MODEL, "body \"%.80s\": found a mass of %g; expected at least 0", name, def->mass);
  if (def->density == 0.0 || (def->density > 0.0 && !def->mesh))
    return km_fail(error, KM_MODEL, "body \"%.80s\": expected a density greater than 0, with a mesh to go with it",
                   name);
  km_model_body body = {.name = name,
                        .assembly = assembly,
                        .mass = def->mass,
                        .center_of_mass = km_vec3_from_array(def->center_of_mass),
                        .density = def->density,
                        .mesh = km_arena_string(&b->model->arena, def->mesh),
                        .where = name};
  memcpy(body.inertia, def->inertia, sizeof body.inertia);
  if (!add_body(b, body))
    return km_builder_memory(error);
  if (out)
    out->value = b->model->body_count;
  return KM_OK;
}

km_status km_model_add_frame(km_builder *b, km_body_id body, const km_frame_def *def, km_frame_id *out,
                             km_error *error) {
  const char *name;
  if (!b || !b->model || !def || body.value < 1 || body.value > b->model->body_count)
    return km_fail(error, KM_MODEL, "frame \"%.80s\": found no body of this builder to put it on",
                   def && def->name ? def->name : "");
  km_status status = km_builder_name(b, "frame", def->name, &b->frames, body.value - 1, "origin", &name, error);
  if (status)
    return status;
  if (!km_builder_sane(def->T, 3) || !km_builder_sane(def->R, 9))
    return insane("frame", name, error);
  km_pose pose = {.p = km_vec3_from_array(def->T)};
  double misfit;
  km_error fault;
  if (km_model_rotation(def->R, &pose.R, &misfit, &fault))
    return km_fail(error, KM_MODEL, "frame \"%.80s\": %s", name, fault.text);
  b->model->rotation_misfit = fmax(b->model->rotation_misfit, misfit);
  if (!add_frame(b, body.value - 1, name, pose))
    return km_builder_memory(error);
  if (out)
    out->value = b->model->frame_count;
  return KM_OK;
}

static km_status first_error(const km_messages *messages, km_error *error) {
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      return km_fail(error, KM_MODEL, "%s", km_messages_text(messages, i));
  return KM_OK;
}

km_status km_builder_finish(km_builder *b, km_model **out, km_error *error) {
  if (!b || !b->model || !out)
    return km_fail(error, KM_USAGE, "found no builder, or one that is finished");
  km_messages *messages = km_messages_create();
  km_names labels = {0};
  km_model *m = b->model;
  *out = NULL;
  km_status status = messages ? KM_OK : km_builder_memory(error);
  if (!status) {
    km_model_check_ties(m, messages);
    km_model_assign_labels(m, &labels, messages);
    km_model_check_inertias(m, messages);
    status = m->arena.failed ? km_builder_memory(error) : first_error(messages, error);
  }
  if (!status) {
    *out = m;
    b->model = NULL;
  }
  km_names_free(&labels);
  km_messages_free(messages);
  forget(b);
  return status;
}
