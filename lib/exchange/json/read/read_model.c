/* The model format's text to a model. */
#include "exchange/json/expression_values.h"
#include "exchange/json/format/format.h"
#include "exchange/json/json.h"
#include "exchange/json/json_meshes.h"
#include "exchange/json/json_model.h"
#include "exchange/json/number_variation.h"
#include "exchange/json/read/reader.h"
#include "exchange/mesh/mesh_folders.h"
#include "exchange/mesh/model_meshes.h"

#include <string.h>

static int count_members(const km_value *object, const char *key) {
  const km_value *list = km_value_get(object, key);
  return list ? (int)list->count : 0;
}

typedef struct totals {
  size_t assemblies, bodies, frames, shapes, joints, struts, couplings, modules;
} totals;

/* Upper bounds: left-out elements count too. */
static void count_assembly(const km_value *assembly, totals *t) {
  const km_value *bodies = km_value_get(assembly, "bodies");
  t->bodies += (size_t)count_members(assembly, "bodies");
  t->joints += (size_t)count_members(assembly, "joints");
  t->frames += 2 * (size_t)count_members(assembly, "joints"); /* those that drawn joints make */
  t->struts += (size_t)count_members(assembly, "struts");
  t->couplings += (size_t)count_members(assembly, "couplings");
  t->modules += (size_t)count_members(assembly, "force_modules");
  for (const km_value *b = bodies ? bodies->first : NULL; b; b = b->next) {
    t->frames += (size_t)count_members(b, "frames");
    t->shapes += (size_t)count_members(b, "shapes");
  }
  const km_value *nested = km_value_get(assembly, "assemblies");
  for (const km_value *a = nested ? nested->first : NULL; a; a = a->next) {
    t->assemblies++;
    count_assembly(a, t);
  }
}

/* The bodies, frames, joints and force modules that struts are made of. */
static void count_struts(totals *t) {
  t->bodies += 2 * t->struts;
  t->frames += 3 * t->struts;
  t->joints += 3 * t->struts;
  t->modules += 2 * t->struts;
}

static struct km_origin *allocate(km_model *model, const km_value *root, size_t *struts) {
  totals t = {0};
  count_assembly(root, &t);
  count_struts(&t);
  *struts = t.struts;
  t.frames += (size_t)count_members(km_value_get(root, "fixed"), "frames") + t.bodies + 1;
  km_arena *arena = &model->arena;
  model->assemblies = KM_ARENA_NEW(arena, km_model_assembly, t.assemblies);
  model->bodies = KM_ARENA_NEW(arena, km_model_body, t.bodies + 1);
  model->frames = KM_ARENA_NEW(arena, km_model_frame, t.frames);
  model->shapes = KM_ARENA_NEW(arena, km_model_shape, t.shapes);
  model->joints = KM_ARENA_NEW(arena, km_model_joint, t.joints);
  model->coordinates = KM_ARENA_NEW(arena, km_model_coordinate, KM_MAX_FREEDOM * t.joints);
  model->couplings = KM_ARENA_NEW(arena, km_model_coupling, t.couplings);
  model->modules = KM_ARENA_NEW(arena, km_model_module, t.modules);
  struct km_origin *origin = KM_ARENA_NEW(arena, struct km_origin, 1);
  if (!origin)
    return NULL;
  *origin = (struct km_origin){root,
                               "1.0",
                               KM_ARENA_NEW(arena, const km_value *, t.bodies + 1),
                               KM_ARENA_NEW(arena, const km_value *, t.joints),
                               KM_ARENA_NEW(arena, const km_value *, t.couplings),
                               KM_ARENA_NEW(arena, const km_value *, t.modules)};
  return origin;
}

static void read_units(km_reader *reader, const km_value *parameters, const km_place *place) {
  km_units *units = &reader->model->units;
  *units = km_units_default();
  const km_value *given = km_value_get(parameters, "units");
  km_place at = {place, "units", 0};
  for (int quantity = 0; quantity < KM_QUANTITIES; ++quantity) {
    const char *key = km_quantity_name((km_quantity)quantity);
    const char *word = km_reader_string(given, key);
    if (!word)
      continue;
    const km_unit *unit = km_unit_find((km_quantity)quantity, word);
    if (unit) {
      *km_units_slot(units, (km_quantity)quantity) = unit;
      continue;
    }
    km_text known = {0};
    for (const km_unit *u = km_quantity_units((km_quantity)quantity); u->word; ++u)
      km_text_format(&known, "%s%s", known.size ? ", " : "", u->word);
    km_place item = {&at, key, 0};
    km_reader_error(reader, &item, "\"%.60s\" is not a unit of %s; expected one of %s", word, key,
                    known.data ? known.data : "");
    km_text_free(&known);
  }
  reader->model->angle_assumed = !km_value_get(given, km_quantity_name(KM_ANGLE));
  reader->model->length_assumed = !km_value_get(given, km_quantity_name(KM_LENGTH));
}

static double read_setting(km_reader *reader, const km_value *simulation, const char *key, const km_place *place) {
  km_place at = {place, key, 0};
  double value = km_reader_number(simulation, key, 0.0);
  if (km_value_get(simulation, key) && !(value > 0.0))
    km_reader_warning(reader, &at, "found %s; expected a positive number: it doesn't count", KM_SHOWN(value));
  return value;
}

static void read_simulation(km_reader *reader, const km_value *parameters, const km_place *place) {
  const km_value *simulation = km_value_get(parameters, "simulation");
  km_place at = {place, "simulation", 0};
  reader->model->simulation = (km_simulation_settings){
      read_setting(reader, simulation, "time_span", &at), read_setting(reader, simulation, "time_step", &at),
      read_setting(reader, simulation, "relative_error", &at), read_setting(reader, simulation, "absolute_error", &at),
      km_reader_string(simulation, "integration_type")};
}

static void read_parameters(km_reader *reader, const km_value *root) {
  km_model *model = reader->model;
  const km_value *parameters = km_value_get(root, "model_parameters");
  km_place place = {NULL, "model_parameters", 0};
  const char *version = km_reader_string(parameters, "version");
  km_place at = {&place, "version", 0};
  if (version && strcmp(version, "0.2") != 0 && strcmp(version, "1.0") != 0 && strcmp(version, "1.1") != 0 &&
      strcmp(version, "1.2") != 0)
    km_reader_error(reader, &at, "version \"%.40s\" is not known; expected \"0.2\", \"1.0\", \"1.1\" or \"1.2\"",
                    version);
  bool newer =
      (version && strcmp(version, "1.1") == 0) || km_value_get(root, "parameters") || km_value_get(root, "poses");
  reader->origin->version = newer || reader->strut_room ? "1.1" : "1.0";
  if (version && strcmp(version, "1.2") == 0)
    km_reader_needs(reader, version);
  read_units(reader, parameters, &place);
  km_read_folders(km_value_get(parameters, "include_dir"), &reader->model->arena, &reader->model->folders);
  model->gravity = km_reader_vector(parameters, "gravity");
  model->gravity_assumed = !km_value_get(parameters, "gravity");
  read_simulation(reader, parameters, &place);
  model->characteristic_length = km_reader_number(parameters, "characteristic_length", 0.0);
  if (km_value_get(parameters, "characteristic_length"))
    km_reader_positive(reader, &place, "characteristic_length", model->characteristic_length);
  km_place length = {&place, "characteristic_length", 0};
  if (model->characteristic_length > 0.0 && !(model->characteristic_length > 1e-100))
    km_reader_error(reader, &length, "found %s; expected a length whose square is a number",
                    KM_SHOWN(model->characteristic_length));
  model->closure_tolerance_given = km_value_get(parameters, "closure_tolerance") != NULL;
  model->closure_tolerance = km_reader_number(parameters, "closure_tolerance", 1e-9);
  km_place tolerance = {&place, "closure_tolerance", 0};
  if (!(model->closure_tolerance > 0.0 && model->closure_tolerance < 0.1))
    km_reader_error(reader, &tolerance, "found %s; expected a number between 0 and 0.1",
                    KM_SHOWN(model->closure_tolerance));
}

int km_reader_add_frame(km_reader *reader, const char *name, int body, km_pose pose) {
  km_model *model = reader->model;
  int index = model->frame_count++;
  model->frames[index] = (km_model_frame){name, body, pose};
  if (!km_names_set(&reader->frames, body, name, index))
    model->arena.failed = true;
  return index;
}

static void left_out(km_reader *reader, km_names *names, int scope, const km_value *element) {
  const char *name = km_reader_string(element, "name");
  if (km_names_get(names, scope, name) == KM_NOT_FOUND && !km_names_set(names, scope, name, KM_LEFT_OUT))
    reader->model->arena.failed = true;
}

static void read_frame(km_reader *reader, const km_value *frame, int body, const km_place *place) {
  if (!km_reader_active(frame)) {
    left_out(reader, &reader->frames, body, frame);
    return;
  }
  const char *name = km_reader_name(reader, frame, place, &reader->frames, body, "origin");
  km_pose pose = {km_reader_orientation(reader, frame, place), km_reader_vector(frame, "T")};
  km_reader_record_pose(reader, frame, km_reader_add_frame(reader, name, body, pose));
}

static void read_body(km_reader *reader, const km_value *value, int assembly, const km_place *place) {
  km_model *model = reader->model;
  if (!km_reader_active(value)) {
    left_out(reader, &reader->bodies, assembly, value);
    return;
  }
  const char *name = km_reader_name(reader, value, place, &reader->bodies, assembly, "fixed");
  int index = model->body_count++;
  km_model_body *body = &model->bodies[index];
  reader->origin->bodies[index] = value;
  *body = (km_model_body){.name = name, .assembly = assembly, .where = km_reader_where(reader, place)};
  km_read_mass(reader, value, place, body);
  const km_value *definition = km_value_get(value, "definition");
  if (definition)
    body->mesh = definition->kind == KM_LIST ? definition->first->string : definition->string;
  if (!km_names_set(&reader->bodies, assembly, name, index))
    model->arena.failed = true;
  km_reader_add_frame(reader, "origin", index, km_pose_identity());
  km_reader_each(reader, value, "frames", index, place, read_frame);
  km_reader_each(reader, value, "shapes", index, place, km_read_shape);
}

static void read_nested(km_reader *reader, const km_value *value, int parent, const km_place *place) {
  km_model *model = reader->model;
  if (!km_reader_active(value)) {
    left_out(reader, &reader->assemblies, parent, value);
    return;
  }
  const char *name = km_reader_name(reader, value, place, &reader->assemblies, parent, "fixed");
  int index = model->assembly_count++;
  model->assemblies[index] = (km_model_assembly){name, parent, false};
  km_read_drawn(reader, value, place, &model->assemblies[index]);
  if (!km_names_set(&reader->assemblies, parent, name, index))
    model->arena.failed = true;
  km_reader_each(reader, value, "bodies", index, place, read_body);
  km_reader_each(reader, value, "assemblies", index, place, read_nested);
}

static void read_elements(km_reader *reader, const km_value *root) {
  km_model *model = reader->model;
  model->bodies[model->body_count++] = (km_model_body){.name = "fixed", .assembly = KM_NO_ASSEMBLY, .where = "fixed"};
  km_reader_add_frame(reader, "origin", 0, km_pose_identity());
  km_place fixed = {NULL, "fixed", 0};
  km_reader_each(reader, km_value_get(root, "fixed"), "frames", 0, &fixed, read_frame);
  km_reader_each(reader, root, "assemblies", KM_NO_ASSEMBLY, NULL, read_nested);
  km_read_joints(reader, root);
  km_read_couplings(reader, root);
  km_read_force_modules(reader, root);
  km_read_analysis(reader, root);
  km_read_poses(reader, root);
}

/* The first error found, as the one that a caller without a message list sees. */
static km_status first_error(const km_messages *messages, km_error *error) {
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    if (km_messages_severity(messages, i) == KM_ERROR)
      return km_fail(error, KM_MODEL, "%s", km_messages_text(messages, i));
  return KM_OK;
}

/* Keys for viewers that drawings don't use. */
static void count_unused(const km_value *assembly, size_t *lights, size_t *materials) {
  const km_value *own = km_value_get(assembly, "lights"), *bodies = km_value_get(assembly, "bodies");
  const km_value *nested = km_value_get(assembly, "assemblies");
  *lights += own ? own->count : 0;
  for (const km_value *b = bodies ? bodies->first : NULL; b; b = b->next) {
    const km_value *definition = km_value_get(b, "definition");
    *materials += definition && definition->kind == KM_LIST && definition->count > 1;
  }
  for (const km_value *a = nested ? nested->first : NULL; a; a = a->next)
    count_unused(a, lights, materials);
}

static void report_unused(const km_value *root, km_messages *messages) {
  size_t lights = 0, materials = 0;
  count_unused(root, &lights, &materials);
  count_unused(km_value_get(root, "fixed"), &lights, &materials);
  if (lights)
    km_messages_add(messages, KM_NOTE, "lights are kept and used by no drawing: %zu", lights);
  if (materials)
    km_messages_add(messages, KM_NOTE,
                    "material files of bodies are kept and used by no drawing: %zu; \"shapes\" have a \"color\"",
                    materials);
}

static void free_names(km_reader *reader) {
  km_names_free(&reader->assemblies);
  km_names_free(&reader->bodies);
  km_names_free(&reader->frames);
  km_names_free(&reader->joints);
  km_names_free(&reader->labels);
}

/* Puts a closure tolerance in the place of the file's. */
static void set_tolerance(km_value *root, double tolerance, km_arena *arena) {
  km_value *parameters = (km_value *)km_value_get(root, "model_parameters");
  if (!parameters && root->kind == KM_OBJECT)
    parameters = km_value_add(arena, root, "model_parameters", KM_OBJECT);
  if (!parameters || parameters->kind != KM_OBJECT) /* reported by the check of the format */
    return;
  km_value *stated = (km_value *)km_value_get(parameters, "closure_tolerance");
  if (!stated) {
    km_value_number(arena, parameters, "closure_tolerance", tolerance);
    return;
  }
  stated->kind = KM_NUMBER;
  stated->number = tolerance;
}

static const char *const word_keys[KM_MODEL_WORDS] = {[KM_WORD_TITLE] = "title",
                                                      [KM_WORD_AUTHOR] = "author",
                                                      [KM_WORD_DATE] = "date",
                                                      [KM_WORD_NOTES] = "notes",
                                                      [KM_WORD_LOGO] = "logo"};

static km_status read_model(km_model *model, const char *bytes, size_t size, const km_read_def *def,
                            km_messages *messages, km_error *error) {
  km_value *root;
  const km_value *source;
  km_status status = km_json_parse_open(bytes, size, &model->arena, &root, error);
  const char *other = status ? NULL : km_other_kind(root, &km_format_model);
  if (other)
    status = km_fail(error, KM_MODEL, "the file is %s; expected a model", other);
  if (!status)
    status = km_model_vary(root, def->assignments, def->assignment_count, &model->arena, error);
  if (!status)
    status = km_model_evaluate(root, messages, error);
  if (status) {
    if (status == KM_MODEL)
      km_messages_add(messages, KM_ERROR, "%s", error->text);
    return status;
  }
  if (def->closure_tolerance > 0.0)
    set_tolerance(root, def->closure_tolerance, &model->arena);
  km_format_check(root, messages);
  if (km_messages_errors(messages))
    return first_error(messages, error);
  km_reader reader = {.model = model, .messages = messages, .arena = &model->arena};
  reader.origin = allocate(model, root, &reader.strut_room);
  if (model->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory while reading the model");
  model->origin = reader.origin;
  source = km_value_get(root, "source");
  model->source = source && source->kind == KM_STRING ? source->string : NULL;
  for (int i = 0; i < KM_MODEL_WORDS; ++i) {
    const km_value *word = km_value_get(root, word_keys[i]);
    model->words[i] = word && word->kind == KM_STRING ? word->string : NULL;
  }
  read_parameters(&reader, root);
  read_elements(&reader, root);
  free_names(&reader);
  km_reader_report_rotations(&reader);
  report_unused(root, messages);
  model->rotation_misfit = reader.rotation_misfit;
  km_model_check_inertias(model, messages);
  if (!model->arena.failed)
    km_model_weigh(model, messages);
  if (model->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory while reading the model");
  return first_error(messages, error);
}

km_status km_json_model(const char *bytes, size_t size, const km_read_def *def, km_messages *messages, km_model **out,
                        km_error *error) {
  km_model *model = KM_NEW(km_model, 1);
  km_status status = KM_MEMORY;
  if (model && km_folders_create(&model->folders, def->file, &model->arena))
    status = read_model(model, bytes, size, def, messages, error);
  else
    km_fail(error, KM_MEMORY, "out of memory while reading the model");
  if (status)
    km_model_free(model);
  else
    *out = model;
  return status;
}
