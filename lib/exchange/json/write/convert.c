/* Converts a valid model: every number in a given unit, in a given configuration. */
#include "exchange/json/write/convert.h"

#include "base/arguments.h"
#include "exchange/json/expression_values.h"
#include "exchange/json/write/write_built.h"

#include "exchange/json/format/format.h"
#include "exchange/json/read/reader.h"
#include "exchange/json/write/convert_drawn.h"
#include "exchange/json/write/write_edits.h"

#include <stdlib.h>
#include <string.h>

/* Context that determines the units of numbers in the current object. */
typedef struct context {
  km_joint_type type;                /* inside a joint */
  int joint;                         /* its index, -1: left out */
  const km_model_coupling *coupling; /* inside a coupling; NULL: left out */
  km_dimension variable, force;      /* inside a force module */
  km_dimension x, value;             /* dimensions of a law */
} context;

/* An object of the file, and the element that it became. */
typedef struct indexed {
  const km_value *source;
  int index;
} indexed;

typedef struct converter {
  const km_model *model;
  const struct km_origin *origin;
  const km_units *units;
  const double *q;
  km_arena *arena;
  bool undraw;     /* the pose isn't the one that is drawn: what is drawn is written as frames */
  indexed *bodies; /* sorted by source */
  indexed *joints; /* sorted by source */
  bool verbatim;   /* expressions stay as they are written */
} converter;

static const km_dimension time_1 = {.time = 1}, length_1 = {.length = 1};

/* A coordinate that counts radians. */
static km_dimension plain(km_joint_type type, int k) {
  return km_joint_is_length(type, k) ? length_1 : (km_dimension){0};
}

static km_dimension generalised_force(bool length) {
  return length ? (km_dimension){.force = 1} : (km_dimension){.force = 1, .length = 1};
}

static int by_source(const void *a, const void *b) {
  const km_value *x = ((const indexed *)a)->source, *y = ((const indexed *)b)->source;
  return (x > y) - (x < y);
}

static indexed *index_sources(const km_value **sources, int count, km_arena *arena) {
  indexed *out = KM_ARENA_NEW(arena, indexed, (size_t)count);
  for (int i = 0; i < count && out; ++i)
    out[i] = (indexed){sources[i], i};
  if (out)
    qsort(out, (size_t)count, sizeof *out, by_source);
  return out;
}

/* The element that an object became; -1: it is left out. */
static int element_of(const indexed *list, int count, const km_value *source) {
  indexed key = {source, 0};
  const indexed *found = bsearch(&key, list, (size_t)count, sizeof key, by_source);
  return found ? found->index : -1;
}

static km_dimension plain_of(const converter *c, int coordinate) {
  const km_model_coordinate *def = &c->model->coordinates[coordinate];
  return plain(c->model->joints[def->joint].type, def->index);
}

/* Dimension of a coordinate's value in a file. */
static km_dimension file_dimension_of(const converter *c, int coordinate) {
  const km_model_coordinate *def = &c->model->coordinates[coordinate];
  return km_joint_dimension(c->model->joints[def->joint].type, def->index);
}

/* The dimension of number `item` of list `row` in a field, inside `depth` lists. */
static km_dimension measured(const converter *c, const context *at, const km_field *field, int depth, int row,
                             int item) {
  const km_model_sweep *sweep = &c->model->sweep;
  switch (field->measure) {
  case KM_MEASURE_COORDINATE:
    return km_joint_dimension(at->type, field->shape == KM_SHAPE_COORDINATES ? item : row);
  case KM_MEASURE_RATIO:
    if (!at->coupling)
      return (km_dimension){0};
    return km_dimension_power(plain_of(c, at->coupling->coordinates[item]), -1);
  case KM_MEASURE_FOLLOWING: {
    if (!at->coupling)
      return (km_dimension){0};
    const int *coupled = at->coupling->coordinates;
    return km_dimension_product(plain_of(c, coupled[0]), km_dimension_power(plain_of(c, coupled[1]), -item));
  }
  case KM_MEASURE_STIFFNESS: {
    bool length = km_joint_is_length(at->type, item);
    return km_dimension_product(generalised_force(length), km_dimension_power(plain(at->type, item), -1));
  }
  case KM_MEASURE_FORCE:
    return generalised_force(km_joint_is_length(at->type, item));
  case KM_MEASURE_INERTIA:
    return km_joint_is_length(at->type, item) ? (km_dimension){.mass = 1} : (km_dimension){.mass = 1, .length = 2};
  case KM_MEASURE_POLYNOMIAL:
    return km_dimension_product(km_joint_dimension(at->type, 0), km_dimension_power(time_1, -item));
  case KM_MEASURE_TABLE:
    return item == 0 ? time_1 : km_joint_dimension(at->type, 0);
  case KM_MEASURE_SWEEP: {
    if (sweep->coordinate < 0)
      return (km_dimension){0};
    const km_model_coordinate *def = &c->model->coordinates[sweep->coordinate];
    return km_joint_dimension(c->model->joints[def->joint].type, def->index);
  }
  case KM_MEASURE_KNOTS:
    return at->variable;
  case KM_MEASURE_REFERENCE:
    return depth == 2 && item == 0 ? time_1
           : depth == 1            ? km_dimension_product(at->variable, km_dimension_power(time_1, -item))
                                   : at->variable;
  case KM_MEASURE_MODULE_FORCE:
    return at->force;
  case KM_MEASURE_PIECES:
    return km_dimension_product(at->force, km_dimension_power(at->variable, -item));
  case KM_MEASURE_LAW_TABLE:
    return item == 0 ? at->variable : at->force;
  case KM_MEASURE_LAW_POLYNOMIAL:
    return km_dimension_product(at->force, km_dimension_power(at->variable, -item));
  case KM_MEASURE_GAIN:
    return km_dimension_product(at->force, km_dimension_power(at->variable, -1));
  case KM_MEASURE_LAW_X:
    return at->x;
  case KM_MEASURE_LAW_VALUE:
    return at->value;
  case KM_MEASURE_LAW_ROWS:
    return item == 0 ? at->x : at->value;
  case KM_MEASURE_LAW_SERIES:
    return km_dimension_product(at->value, km_dimension_power(at->x, -item));
  default:
    return (km_dimension){0};
  }
}

static double in_new_units(const converter *c, double number, km_dimension dimension) {
  double from = km_units_factor(&c->model->units, dimension), to = km_units_factor(c->units, dimension);
  return from == to ? number : number * (from / to);
}

static void copy(const converter *c, km_value *parent, const char *key, const km_value *value) {
  if (value->kind == KM_NUMBER && value->string && c->verbatim) {
    km_value_string(c->arena, parent, key, value->string);
    return;
  }
  km_value *twin = km_value_add(c->arena, parent, key, value->kind);
  if (!twin)
    return;
  twin->number = value->number;
  twin->string = km_arena_string(c->arena, value->string);
  for (const km_value *v = value->first; v; v = v->next)
    copy(c, twin, v->key, v);
}

/* A number, a list of them or a list of such lists, each in its unit. */
static void convert_numbers(const converter *c, const context *at, const km_field *field, km_value *parent,
                            const char *key, const km_value *value, int depth, int row, int item) {
  if (value->kind == KM_NUMBER && !(value->string && c->verbatim)) {
    km_dimension dimension = km_dimension_product(measured(c, at, field, depth, row, item), field->dimension);
    km_value_number(c->arena, parent, key, in_new_units(c, value->number, dimension));
    return;
  }
  if (value->kind != KM_LIST) {
    copy(c, parent, key, value);
    return;
  }
  km_value *list = km_value_add(c->arena, parent, key, KM_LIST);
  bool rows = depth == 0 && value->first && value->first->kind == KM_LIST;
  int index = 0;
  for (const km_value *v = value->first; v; v = v->next, ++index)
    convert_numbers(c, at, field, list, NULL, v, depth + 1, rows ? index : row, rows ? 0 : index);
}

static void add_number(km_text *out, const char *before, double number, const char *after) {
  char text[KM_NUMBER_TEXT];
  km_number_format(text, number);
  km_text_format(out, "%s%s%s", before, text, after);
}

/* An expression of the time in other units: factor · f(t / factor of the time), with the values of parameters. */
static void convert_expression(const converter *c, const context *at, const km_field *field, const km_value *value,
                               km_value *parent) {
  const km_value *parameters = km_value_get(c->origin->root, "parameters");
  double factor = in_new_units(c, 1.0, measured(c, at, field, 0, 0, 0)), time = in_new_units(c, 1.0, time_1), number;
  km_text out = {0};
  if (c->verbatim) {
    copy(c, parent, value->key, value);
    return;
  }
  if (factor != 1.0)
    add_number(&out, "", factor, "*(");
  for (const char *from = value->string; *from;) {
    size_t digits = km_expression_number(from), name = digits ? 0 : km_expression_name(from);
    size_t length = digits ? digits : name ? name : 1;
    if (name == 1 && *from == 't' && time != 1.0)
      add_number(&out, "(t/", time, ")");
    else if (name && km_parameter_value(parameters, from, name, &number))
      add_number(&out, "(", number, ")");
    else
      km_text_bytes(&out, from, length);
    from += length;
  }
  if (factor != 1.0)
    km_text_add(&out, ")");
  km_value_string(c->arena, parent, value->key, out.data ? out.data : "");
  km_text_free(&out);
}

/* {label: coordinates} of `hold` and of poses. */
static void convert_map(const converter *c, const km_value *value, km_value *parent) {
  static const km_field field = {.key = "hold", .shape = KM_SHAPE_COORDINATES, .measure = KM_MEASURE_COORDINATE};
  km_value *map = km_value_add(c->arena, parent, value->key, KM_OBJECT);
  for (const km_value *v = value->first; v; v = v->next) {
    int joint, coordinate;
    context at = {0};
    if (km_model_find_coordinate(c->model, v->key, &coordinate, NULL) == KM_OK) {
      at.type = km_model_coordinate_is_length(c->model, coordinate) ? KM_TX : KM_RX;
    } else if (km_model_find_joint(c->model, v->key, &joint, NULL) == KM_OK) {
      at.type = c->model->joints[joint].type;
    }
    convert_numbers(c, &at, &field, map, v->key, v, 0, 0, 0);
  }
}

/* True if a port is a length, not an angle. */
static bool port_is_length(const converter *c, int port, km_distance distance) {
  return port < 0 ? distance <= KM_DISTANCE_Z : km_model_coordinate_is_length(c->model, port);
}

static km_dimension variable_dimension(km_dimension displacement, km_module_variable variable) {
  return variable == KM_VARIABLE_TIME ? time_1
                                      : km_dimension_product(displacement, km_dimension_power(time_1, -(int)variable));
}

/* Dimensions of the variable and the force of a module; one that is left out is taken for one of lengths. */
static void enter_module(const converter *c, const km_value *module, context *at) {
  const km_value *type = km_value_get(module, "type");
  int found = type && type->string ? km_module_type_find(type->string) : -1;
  km_module_variable variable = found < 0 ? KM_VARIABLE_DISPLACEMENT : km_module_type_variable((km_module_type)found);
  at->variable = variable_dimension(length_1, variable);
  at->force = generalised_force(true);
  for (int i = 0; i < c->model->module_count; ++i) {
    const km_model_module *def = &c->model->modules[i];
    const km_module_input *in = def->inputs;
    if (c->origin->modules[i] != module || def->input_count == 0)
      continue;
    bool is_component = in->port.coordinate == KM_MODULE_PORT_FRAME;
    bool is_length = is_component ? in->component < 3 : port_is_length(c, in->port.coordinate, in->distance);
    at->variable = variable_dimension(is_length ? length_1 : (km_dimension){0}, def->variable);
    if (km_value_get(module, "over") && def->variable == KM_VARIABLE_DISPLACEMENT)
      at->variable = file_dimension_of(c, in->port.coordinate);
    at->force = generalised_force(port_is_length(c, def->output.coordinate, def->distance));
  }
  at->x = at->variable;
  at->value = at->force;
}

/* The factor of a load over a joint, which counts in the file's unit, or over time. */
static void enter_scale(const converter *c, const km_value *scale, context *at) {
  char text[KM_PLACE_TEXT];
  const km_value *over = km_value_get(scale, "over");
  int coordinate;
  at->x = time_1;
  at->value = (km_dimension){0};
  if (over && km_model_find_coordinate(c->model, km_path_text(over, text), &coordinate, NULL) == KM_OK)
    at->x = file_dimension_of(c, coordinate);
}

static void enter(const converter *c, const km_object_format *format, const km_value *object, context *at) {
  if (format == &km_format_joint) {
    const km_value *type = km_value_get(object, "type");
    int found = type && type->string ? km_joint_type_find(type->string) : -1;
    at->type = found < 0 ? KM_RIGID : (km_joint_type)found;
    at->joint = element_of(c->joints, c->model->joint_count, object);
    at->x = time_1;
    at->value = km_joint_dimension(at->type, 0);
  } else if (format == &km_format_strut) {
    at->type = KM_TX;
  } else if (format == &km_format_scale) {
    enter_scale(c, object, at);
  } else if (format == &km_format_module) {
    enter_module(c, object, at);
  } else if (format == &km_format_coupling) {
    at->coupling = NULL;
    for (int i = 0; i < c->model->coupling_count; ++i)
      if (c->origin->couplings[i] == object)
        at->coupling = &c->model->couplings[i];
  }
}

static void convert_object(const converter *c, const context *outer, const km_object_format *format,
                           const km_value *object, km_value *parent, const char *key);

static void convert_field(const converter *c, const context *at, const km_field *field, const km_value *value,
                          km_value *parent) {
  switch (field ? field->shape : KM_SHAPE_ANY) {
  case KM_SHAPE_OBJECT:
    convert_object(c, at, field->object, value, parent, value->key);
    break;
  case KM_SHAPE_OBJECTS: {
    km_value *list = km_value_add(c->arena, parent, value->key, KM_LIST);
    for (const km_value *v = value->first; v; v = v->next)
      convert_object(c, at, field->object, v, list, NULL);
    break;
  }
  case KM_SHAPE_COORDINATE_MAP:
    convert_map(c, value, parent);
    break;
  case KM_SHAPE_POSES: {
    km_value *poses = km_value_add(c->arena, parent, value->key, KM_OBJECT);
    for (const km_value *v = value->first; v; v = v->next)
      convert_map(c, v, poses);
    break;
  }
  case KM_SHAPE_PARAMETERS: /* numbers in the file's units without a known dimension, which aren't used */
    if (c->verbatim)
      copy(c, parent, value->key, value);
    break;
  case KM_SHAPE_EXPRESSION:
    convert_expression(c, at, field, value, parent);
    break;
  case KM_SHAPE_NUMBER:
  case KM_SHAPE_VECTOR:
  case KM_SHAPE_POINT:
  case KM_SHAPE_NUMBERS:
  case KM_SHAPE_COORDINATES:
  case KM_SHAPE_RANGE:
  case KM_SHAPE_RANGES:
  case KM_SHAPE_ROWS:
  case KM_SHAPE_TIME_LAW:
    if (value->kind == KM_STRING)
      convert_expression(c, at, field, value, parent);
    else
      convert_numbers(c, at, field, parent, value->key, value, 0, 0, 0);
    break;
  default:
    copy(c, parent, value->key, value);
  }
}

/* The pose of a joint that is in the model, in the new units. */
static void write_displacement(const converter *c, int joint, km_value *parent) {
  const km_model_joint *def = &c->model->joints[joint];
  int freedom = km_model_freedom(c->model, joint);
  double values[KM_MAX_FREEDOM];
  for (int k = 0; k < freedom; ++k)
    values[k] = in_new_units(c, c->q[def->first_coordinate + k], km_joint_dimension(def->type, k));
  if (freedom == 1)
    km_value_number(c->arena, parent, "initial_displacement", values[0]);
  else if (freedom > 1)
    km_value_numbers(c->arena, parent, "initial_displacement", values, (size_t)freedom);
}

/* True if the key is replaced in the output. */
static bool is_replaced(const converter *c, const context *at, const km_object_format *format, const char *key) {
  bool joint = format == &km_format_joint && at->joint >= 0;
  if (joint && strcmp(key, "initial_displacement") == 0)
    return c->q && (c->undraw || !km_joint_in_drawing(c->model, at->joint));
  if (!c->undraw)
    return false;
  return strcmp(key, "drawn") == 0 ||
         (joint && (strcmp(key, "bodies") == 0 || strcmp(key, "at") == 0 || strcmp(key, "axis") == 0));
}

/* Writes the keys that are replaced. */
static void write_replacements(const converter *c, const context *at, const km_object_format *format,
                               const km_value *object, km_value *twin) {
  bool joint = format == &km_format_joint;
  if (c->undraw && joint && at->joint >= 0 && km_joint_is_drawn(object))
    km_write_drawn_pair(c->model, at->joint, c->arena, twin);
  if (c->undraw && joint && at->joint < 0 && km_joint_is_drawn(object) && km_reader_active(object))
    km_value_boolean(c->arena, twin, "active", 0);
  if (joint && at->joint >= 0 && is_replaced(c, at, format, "initial_displacement"))
    write_displacement(c, at->joint, twin);
  int body = format == &km_format_fixed  ? 0
             : format == &km_format_body ? element_of(c->bodies, c->model->body_count, object)
                                         : -1;
  if (c->undraw && body >= 0)
    km_write_drawn_frames(c->model, body, in_new_units(c, 1.0, length_1), c->arena, twin);
}

static void convert_object(const converter *c, const context *outer, const km_object_format *format,
                           const km_value *object, km_value *parent, const char *key) {
  context at = *outer;
  enter(c, format, object, &at);
  km_value *twin = km_value_add(c->arena, parent, key, KM_OBJECT);
  for (const km_value *v = object->first; v && twin; v = v->next)
    if (!is_replaced(c, &at, format, v->key))
      convert_field(c, &at, km_format_field(format, v->key), v, twin);
  if (twin)
    write_replacements(c, &at, format, object, twin);
}

/* model_parameters with everything that a reader would otherwise assume. */
static void convert_parameters(const converter *c, const km_value *parameters, km_value *parent) {
  static const char *const stated[] = {"version", "units", "characteristic_length", NULL};
  const km_field *field = km_format_field(&km_format_model, "model_parameters");
  context at = {0};
  km_value *twin = km_value_add(c->arena, parent, "model_parameters", KM_OBJECT);
  if (!twin)
    return;
  km_value_string(c->arena, twin, "version", c->origin->version);
  km_value *units = km_value_add(c->arena, twin, "units", KM_OBJECT);
  km_units new = *c->units;
  for (int q = 0; q < KM_QUANTITIES && units; ++q)
    km_value_string(c->arena, units, km_quantity_name((km_quantity)q), (*km_units_slot(&new, (km_quantity)q))->word);
  if (c->model->characteristic_length > 0.0)
    km_value_number(c->arena, twin, "characteristic_length",
                    in_new_units(c, c->model->characteristic_length, length_1));
  for (const km_value *v = parameters ? parameters->first : NULL; v; v = v->next) {
    bool done = false;
    for (const char *const *word = stated; *word; ++word)
      done = done || strcmp(v->key, *word) == 0;
    if (!done)
      convert_field(c, &at, km_format_field(field->object, v->key), v, twin);
  }
}

km_status km_check_convert(const km_model *model, const km_units *units, const double *q, const km_arena *arena,
                           const km_value **out, km_error *error) {
  km_status status = km_check_given(model && arena, "model, or no arena", error);
  if (!status)
    status = km_check_given(units && units->angle && units->length && units->mass && units->time && units->force,
                            "units", error);
  if (!status)
    status = km_check_given(out != NULL, "place for the result", error);
  for (int c = 0; q && !status && c < model->coordinate_count; ++c)
    if (!isfinite(q[c]))
      status = km_fail(error, KM_USAGE, "found a displacement that is not finite");
  return status;
}

/* A model with changed numbers: its file is written first, then what has changed. */
static km_status convert_edited(const km_model *model, const km_units *units, const double *q, bool frames,
                                km_arena *arena, const km_value **out, km_error *error) {
  km_model file = km_edits_undone(model);
  double *present = KM_ARENA_NEW(arena, double, (size_t)model->coordinate_count);
  if (!present)
    return km_fail(error, KM_MEMORY, "out of memory while converting the model");
  for (int c = 0; c < model->coordinate_count; ++c)
    present[c] = q ? q[c] : model->coordinates[c].position;
  bool undrawn = frames || km_edits_break_drawing(model) || km_drawing_moved(&file, present);
  km_status status = km_model_convert(&file, units, present, undrawn, arena, out, error);
  return status ? status : km_edits_write(model, units, !undrawn, arena, (km_value *)*out, error);
}

km_status km_model_convert(const km_model *model, const km_units *units, const double *q, bool frames, km_arena *arena,
                           const km_value **out, km_error *error) {
  km_status sound = km_check_convert(model, units, q, arena, out, error);
  if (sound)
    return sound;
  if (!model->origin)
    return km_built_convert(model, units, q, frames, arena, out, error);
  if (model->unedited)
    return convert_edited(model, units, q, frames, arena, out, error);
  const km_value *given = model->origin->root;
  bool undraw = frames || (q && km_drawing_moved(model, q));
  converter c = {.model = model,
                 .origin = model->origin,
                 .units = units,
                 .q = q,
                 .arena = arena,
                 .undraw = undraw,
                 .bodies = index_sources(model->origin->bodies, model->body_count, arena),
                 .joints = index_sources(model->origin->joints, model->joint_count, arena),
                 .verbatim = !undraw && memcmp(units, &model->units, sizeof *units) == 0};
  km_value *root = km_value_add(arena, NULL, NULL, KM_OBJECT);
  context at = {.joint = -1};
  if (!arena->failed) {
    convert_parameters(&c, km_value_get(given, "model_parameters"), root);
    for (const km_value *v = given->first; v; v = v->next)
      if (strcmp(v->key, "model_parameters") != 0)
        convert_field(&c, &at, km_format_field(&km_format_model, v->key), v, root);
    if (!km_value_get(given, "fixed") && c.undraw)
      convert_object(&c, &at, &km_format_fixed, &(km_value){.kind = KM_OBJECT}, root, "fixed");
  }
  *out = root;
  return arena->failed ? km_fail(error, KM_MEMORY, "out of memory while converting the model") : KM_OK;
}

bool km_model_has_parameters(const km_model *model) {
  return model && model->origin && km_value_get(model->origin->root, "parameters") != NULL;
}
