/* Force modules: their laws, and where they measure and act. */
#include "exchange/json/read/reader.h"

#include <math.h>
#include <string.h>

/* The place of a word in a list that ends with NULL; -1: it isn't there. */
static int place_of(const char *word, const char *const *words) {
  for (int i = 0; words[i]; ++i)
    if (strcmp(word, words[i]) == 0)
      return i;
  return -1;
}

/* Numbers of a list, or of a list of lists one after the other; NULL where there are none. */
static double *numbers_of(km_reader *reader, const km_value *list, size_t *count) {
  size_t total = 0;
  for (const km_value *v = list ? list->first : NULL; v; v = v->next)
    total += v->kind == KM_LIST ? v->count : 1;
  double *out = total ? KM_ARENA_NEW(&reader->model->arena, double, total) : NULL;
  *count = 0;
  for (const km_value *v = out ? list->first : NULL; v; v = v->next)
    for (const km_value *n = v->kind == KM_LIST ? v->first : v; n; n = v->kind == KM_LIST ? n->next : NULL)
      out[(*count)++] = n->number;
  return out;
}

/* A number, a polynomial over time, or rows [time, value]. */
static void read_reference(km_reader *reader, const km_value *module, const km_place *place, km_law_curve *out) {
  km_arena *arena = &reader->model->arena;
  const km_value *reference = km_value_get(module, "reference");
  km_place at = {place, "reference", 0};
  size_t errors = km_messages_errors(reader->messages), count;
  *out = km_curve_constant(arena, reference && reference->kind == KM_NUMBER ? reference->number : 0.0);
  if (reference && reference->kind == KM_STRING)
    km_read_expression(reader, reference->string, &at, out);
  if (!reference || reference->kind != KM_LIST)
    return;
  bool is_table = reference->first && reference->first->kind == KM_LIST;
  double *numbers = numbers_of(reader, reference, &count);
  if (is_table)
    km_check_rows(reader, reference, "time", &at);
  if (!is_table)
    *out = (km_law_curve){.form = KM_CURVE_POLYNOMIAL, .count = (int)count, .numbers = numbers};
  else if (numbers && km_messages_errors(reader->messages) == errors)
    arena->failed = km_curve_from_rows(numbers, (int)(count / 2), false, 0.0, arena, out) != KM_CURVE_OK;
}

/* Knots and polynomials; a motor's polynomial in time is one without knots. */
static void read_law(km_reader *reader, const km_value *module, const km_place *place, km_model_module *out) {
  const km_value *pieces = km_value_get(module, "coefficients"), *polynomial = km_value_get(module, "polynomial");
  size_t knots, total;
  km_law law = {.knots = numbers_of(reader, km_value_get(module, "knot_points"), &knots)};
  size_t count = pieces ? pieces->count : polynomial ? 1 : 0;
  int *start = KM_ARENA_NEW(&reader->model->arena, int, count + 1), piece = 0;
  law.knot_count = (int)knots;
  law.start = start;
  law.coefficients = numbers_of(reader, pieces ? pieces : polynomial, &total);
  for (const km_value *p = start && pieces ? pieces->first : NULL; p; p = p->next, ++piece)
    start[piece + 1] = start[piece] + (int)p->count;
  if (start && !pieces && polynomial)
    start[1] = (int)total;
  out->law = law;
  read_reference(reader, module, place, &out->reference);
  out->kp = km_reader_number(module, "kp", 0.0);
  out->ki = km_reader_number(module, "ki", 0.0);
  out->kd = km_reader_number(module, "kd", 0.0);
}

static void read_tire(km_reader *reader, const km_value *module, const km_place *place, km_tire *out) {
  const km_value *t = km_value_get(module, "tire");
  km_place at = {place, "tire", 0};
  *out = (km_tire){
      .radius = km_reader_number(t, "unloaded_radius", 0.0),
      .stiffness = km_reader_number(t, "vertical_stiffness", 0.0),
      .damping = km_reader_number(t, "vertical_damping", 0.0),
      .rolling_resistance = km_reader_number(t, "rolling_resistance", 0.0),
      .width = km_reader_number(t, "width", 0.0),
      .longitudinal = km_reader_number(t, "longitudinal_stiffness", 0.0),
      .lateral = km_reader_number(t, "lateral_stiffness", 0.0),
      .friction_peak = km_reader_number(t, "friction_peak", 1.0),
      .relaxation = {km_reader_number(t, "relaxation_length_x", 0.0), km_reader_number(t, "relaxation_length_y", 0.0)}};
  out->friction_sliding = km_reader_number(t, "friction_sliding", out->friction_peak);
  static const char *const numbers[] = {
      "unloaded_radius",        "vertical_stiffness", "vertical_damping", "rolling_resistance", "width",
      "longitudinal_stiffness", "lateral_stiffness",  "friction_peak",    "friction_sliding",   "relaxation_length_x",
      "relaxation_length_y"};
  for (size_t i = 0; t && i < sizeof numbers / sizeof *numbers; ++i)
    km_reader_not_negative(reader, t, numbers[i], &at);
}

static void read_contact(km_reader *reader, const km_value *module, const km_place *place, km_contact *out) {
  const km_value *t = km_value_get(module, "contact");
  const char *shape = t ? km_reader_string(t, "shape") : NULL;
  km_place at = {place, "contact", 0}, shape_at = {&at, "shape", 0};
  if (!t)
    km_reader_error(reader, place, "\"contact\" is missing; expected the shape and the numbers of a contact");
  int found = shape ? km_contact_shape_find(shape) : 0;
  if (found < 0)
    km_reader_error(reader, &shape_at, "\"%.40s\" is no contact; expected point-plane, circle-line, circle-circle or "
                    "circle-in-circle",
                    shape);
  *out = (km_contact){.shape = found < 0 ? KM_CONTACT_POINT_PLANE : (km_contact_shape)found,
                      .radius = km_reader_number(t, "radius", 0.0),
                      .parent_radius = km_reader_number(t, "parent_radius", 0.0),
                      .stiffness = km_reader_number(t, "stiffness", 0.0),
                      .exponent = km_reader_number(t, "exponent", 1.0),
                      .reference_depth = km_reader_number(t, "reference_depth", 0.0),
                      .dissipation = km_reader_number(t, "dissipation", 0.0),
                      .friction = km_reader_number(t, "friction", 0.0),
                      .slip_speed = km_reader_number(t, "slip_speed", 0.0)};
  static const char *const numbers[] = {"radius",          "parent_radius", "stiffness", "exponent",
                                        "reference_depth", "dissipation",   "friction",  "slip_speed"};
  for (size_t i = 0; t && i < sizeof numbers / sizeof *numbers; ++i)
    km_reader_not_negative(reader, t, numbers[i], &at);
}

static const char *const distances[] = {"euclid", "Tx", "Ty", "Tz", "Rx", "Ry", "Rz", NULL};

/* Measure between two frames that a key names; euclid if it isn't there. */
static km_distance read_distance(km_reader *reader, const km_value *object, const km_place *place) {
  const char *distance = km_reader_string(object, "distance_type");
  km_place at = {place, "distance_type", 0};
  int found = distance ? place_of(distance, distances) : 0;
  if (found < 0)
    km_reader_error(reader, &at, "\"%.40s\" is not a distance; expected euclid, Tx, Ty, Tz, Rx, Ry or Rz", distance);
  return found < 0 ? KM_DISTANCE_EUCLID : (km_distance)found;
}

/* One frame with a component of its motion. */
static void read_component(km_reader *reader, const km_value *port, int assembly, const km_place *place,
                           km_module_input *out) {
  static const char *const components[] = {"x", "y", "z", "wx", "wy", "wz", NULL}, *const axes[] = {"fixed", "body",
                                                                                                    NULL};
  const char *component = km_reader_string(port, "component"), *along = km_reader_string(port, "axes");
  km_place frame_at = {place, "frame", 0}, component_at = {place, "component", 0}, axes_at = {place, "axes", 0};
  out->port = (km_module_port){KM_MODULE_PORT_FRAME, {0, 0}};
  out->port.frame[0] = km_reader_frame(reader, km_value_get(port, "frame"), assembly, &frame_at);
  out->component = component ? place_of(component, components) : -1;
  int axes_found = along ? place_of(along, axes) : 0;
  if (!component)
    km_reader_error(reader, place, "\"component\" is missing; expected x, y, z, wx, wy or wz");
  else if (out->component < 0)
    km_reader_error(reader, &component_at, "\"%.40s\" is not a component; expected x, y, z, wx, wy or wz", component);
  if (axes_found < 0)
    km_reader_error(reader, &axes_at, "\"%.40s\" are no axes; expected fixed or body", along);
  out->component = out->component < 0 ? 0 : out->component;
  out->body_axes = axes_found == 1;
}

/* A joint, two frames, or (`may_be_frame`) a component of one frame's motion. False where it names what is left out. */
static bool read_port(km_reader *reader, const km_value *port, int assembly, bool may_be_frame, const km_place *place,
                      km_module_input *out) {
  const char *type = km_reader_string(port, "type");
  const km_value *joint = km_value_get(port, "joint"), *pair = km_value_get(port, "body_frame_pair"),
                 *frame = km_value_get(port, "frame");
  km_place type_at = {place, "type", 0}, joint_at = {place, "joint", 0}, pair_at = {place, "body_frame_pair", 0};
  *out = (km_module_input){.port = {KM_MODULE_PORT_FRAMES, {0, 0}}, .weight = km_reader_number(port, "weight", 1.0)};
  if (type && strcmp(type, "joint") != 0 && strcmp(type, "frame") != 0) {
    km_reader_error(reader, &type_at, "\"%.40s\" is not a kind of port; expected \"joint\" or \"frame\"", type);
    return true;
  }
  bool is_joint = type ? strcmp(type, "joint") == 0 : joint != NULL;
  if (is_joint) {
    if (joint)
      out->port.coordinate = km_reader_coordinate(reader, joint, assembly, &joint_at);
    else
      km_reader_error(reader, place, "\"joint\" is missing; expected the joint of this port");
    return out->port.coordinate != KM_LEFT_OUT;
  }
  if (frame && may_be_frame) {
    read_component(reader, port, assembly, place, out);
  } else if (!pair) {
    km_reader_error(reader, place, "\"body_frame_pair\" is missing; expected the two frames of this port");
  } else {
    km_place first = {&pair_at, NULL, 0}, second = {&pair_at, NULL, 1};
    out->port.frame[0] = km_reader_frame(reader, pair->first, assembly, &first);
    out->port.frame[1] = km_reader_frame(reader, pair->last, assembly, &second);
    out->distance = read_distance(reader, port, place);
  }
  return out->port.frame[0] != KM_LEFT_OUT && out->port.frame[1] != KM_LEFT_OUT;
}

/* The module's measure between frames, for a port without one. */
static void read_common_distance(km_reader *reader, const km_value *port, const km_value *module, const km_place *place,
                                 km_module_input *out) {
  if (!km_value_get(port, "distance_type") && out->port.coordinate == KM_MODULE_PORT_FRAMES)
    out->distance = read_distance(reader, module, place);
}

/* The inputs of a module: those of `inputs`, else `input`, else the output. False where one names what is left out. */
static bool read_inputs(km_reader *reader, const km_value *module, int assembly, const km_place *place,
                        km_model_module *out) {
  const km_value *list = km_value_get(module, "inputs"), *input = km_value_get(module, "input"),
                 *output = km_value_get(module, "output");
  const km_value *only = input ? input : output;
  size_t count = list ? list->count : only ? 1 : 0;
  km_module_input *inputs = KM_ARENA_NEW(&reader->model->arena, km_module_input, count + 1);
  bool complete = true;
  km_place list_at = {place, "inputs", 0}, item = {&list_at, NULL, 0}, only_at = {place, input ? "input" : "output", 0};
  if (list && input)
    km_reader_warning(reader, &only_at, "doesn't count: the module has %s", "\"inputs\"");
  for (const km_value *v = list && inputs ? list->first : NULL; v; v = v->next, ++item.index) {
    complete = read_port(reader, v, assembly, true, &item, &inputs[item.index]) && complete;
    read_common_distance(reader, v, module, place, &inputs[item.index]);
  }
  if (!list && only && inputs) {
    complete = read_port(reader, only, assembly, true, &only_at, &inputs[0]);
    read_common_distance(reader, only, module, place, &inputs[0]);
  }
  out->inputs = inputs;
  out->input_count = inputs ? (int)count : 0;
  out->input = count && inputs ? inputs[0].port : (km_module_port){KM_MODULE_PORT_FRAMES, {0, 0}};
  return complete;
}

/* The output: by default the only input. */
static bool read_output(km_reader *reader, const km_value *module, int assembly, const km_place *place,
                        km_model_module *out) {
  const km_value *output = km_value_get(module, "output");
  km_place at = {place, "output", 0};
  km_module_input port;
  out->output = out->input;
  out->distance = out->input_count ? out->inputs[0].distance : KM_DISTANCE_EUCLID;
  if (output) {
    bool complete = read_port(reader, output, assembly, false, &at, &port);
    out->output = port.port;
    out->distance = km_value_get(output, "distance_type") ? port.distance : read_distance(reader, module, place);
    return complete;
  }
  if (out->input_count > 1 || out->input.coordinate == KM_MODULE_PORT_FRAME)
    km_reader_error(reader, place, "\"output\" is missing; expected the joint or the frames on which the force acts");
  return true;
}

/* The variable and the bounds of the force. */
static void read_variable(km_reader *reader, const km_value *module, const km_place *place, km_model_module *out) {
  static const char *const variables[] = {"displacement", "velocity", "acceleration", "time", NULL};
  const char *variable = km_reader_string(module, "variable");
  const km_value *bounds = km_value_get(module, "saturation");
  km_place at = {place, "variable", 0}, bounds_at = {place, "saturation", 0};
  int found = variable ? place_of(variable, variables) : (int)km_module_type_variable(out->type);
  if (found < 0)
    km_reader_error(reader, &at, "\"%.40s\" is not a variable; expected displacement, velocity, acceleration or time",
                    variable);
  out->variable = found < 0 ? KM_VARIABLE_DISPLACEMENT : (km_module_variable)found;
  if (found == KM_VARIABLE_TIME && out->type != KM_MODULE_MOTOR)
    km_reader_error(reader, &at, "only motors read the time; expected displacement, velocity or acceleration");
  if (found == KM_VARIABLE_ACCELERATION && out->type == KM_MODULE_PID && out->kd != 0.0)
    km_reader_error(reader, &at, "\"kd\" of an acceleration is a jerk; expected kp and ki alone");
  for (int i = 0; i < out->input_count && found == KM_VARIABLE_DISPLACEMENT && out->type != KM_MODULE_TIRE; ++i)
    if (out->inputs[i].port.coordinate == KM_MODULE_PORT_FRAME && out->inputs[i].component >= 3)
      km_reader_error(reader, place,
                      "a component wx, wy or wz has no displacement; expected \"variable\" velocity or "
                      "acceleration, or two frames with Rx, Ry or Rz");
  if (!bounds)
    return;
  out->saturates = true;
  out->least = bounds->first->number;
  out->most = bounds->last->number;
  if (out->least > out->most)
    km_reader_error(reader, &bounds_at, "found %s above %s; expected [least, greatest]", KM_SHOWN(out->least),
                    KM_SHOWN(out->most));
}

static void check_pieces(km_reader *reader, const km_value *module, const km_place *place) {
  const km_value *knots = km_value_get(module, "knot_points"), *pieces = km_value_get(module, "coefficients");
  km_place knots_at = {place, "knot_points", 0}, pieces_at = {place, "coefficients", 0};
  double last = -HUGE_VAL;
  for (const km_value *k = knots ? knots->first : NULL; k; k = k->next) {
    if (!(k->number > last))
      km_reader_error(reader, &knots_at, "found %s after %s; expected increasing knots", KM_SHOWN(k->number),
                      KM_SHOWN(last));
    last = k->number;
  }
  size_t wanted = (knots ? knots->count : 0) + 1;
  if (pieces && pieces->count != wanted)
    km_reader_error(reader, &pieces_at, "found %zu polynomials; expected %zu, one more than the knots", pieces->count,
                    wanted);
}

/* Required keys of a type of force module: at least one of them. */
static void check_law(km_reader *reader, const km_value *module, const char *type, bool has_curve,
                      const km_place *place) {
  static const struct {
    const char *type, *keys[3], *words;
  } laws[] = {{"stiffness", {"coefficients"}, "\"coefficients\""},
              {"damping", {"coefficients"}, "\"coefficients\""},
              {"friction", {"coefficients"}, "\"coefficients\""},
              {"motor", {"polynomial", "coefficients"}, "\"polynomial\" or \"table\""},
              {"pid", {"kp", "ki", "kd"}, "\"kp\", \"ki\" or \"kd\""}};
  for (size_t i = 0; i < sizeof laws / sizeof *laws; ++i) {
    bool given = strcmp(laws[i].type, type) != 0 || has_curve;
    for (size_t k = 0; k < 3 && laws[i].keys[k]; ++k)
      given = given || km_value_get(module, laws[i].keys[k]);
    if (!given)
      km_reader_error(reader, place, "%s is missing; expected the law of a %s", laws[i].words, type);
  }
}

/* True if a module of a law is a curve: a motor's table; a table of another module without polynomials; a cosine or a
 * step; or a polynomial over another variable. */
static bool has_curve(const km_value *module, const km_model_module *def) {
  if (def->type > KM_MODULE_MOTOR)
    return false;
  bool has_table =
      km_value_get(module, "table") && (def->type == KM_MODULE_MOTOR || !km_value_get(module, "coefficients"));
  return has_table || km_value_get(module, "cosine") || km_value_get(module, "step") ||
         km_value_get(module, "expression") || (km_value_get(module, "over") && km_value_get(module, "polynomial"));
}

/* One of several laws of a module is used: a curve before pieces, pieces before a polynomial. */
static void warn_unused_laws(km_reader *reader, const km_value *module, const km_model_module *def,
                             const km_place *place) {
  km_place table = {place, "table", 0}, pieces = {place, "coefficients", 0}, polynomial = {place, "polynomial", 0};
  bool table_given = km_value_get(module, "table"), table_counts = table_given && has_curve(module, def),
       has_pieces = km_value_get(module, "coefficients");
  if (table_given && !table_counts)
    km_reader_warning(reader, &table, "doesn't count: the module has %s", has_pieces ? "coefficients" : "no law");
  if (table_counts && has_pieces)
    km_reader_warning(reader, &pieces, "doesn't count: the motor has a table");
  if (km_value_get(module, "polynomial") && (table_counts || has_pieces))
    km_reader_warning(reader, &polynomial, "doesn't count: the module has %s",
                      table_counts ? "a table" : "coefficients");
}

/* The joint or time that `over` names becomes the module's input and variable. False where it is left out. */
static bool read_over(km_reader *reader, const km_value *module, int assembly, const km_place *place,
                      km_model_module *out) {
  const km_value *over = km_value_get(module, "over");
  km_place at = {place, "over", 0};
  if (!over)
    return true;
  const char *const others[] = {"input", "inputs", "variable", "coefficients", "knot_points", NULL};
  for (const char *const *key = others; *key; ++key)
    if (km_value_get(module, *key))
      km_reader_error(reader, &at, "found it beside \"%s\"; expected one of them", *key);
  const bool is_time = over->kind == KM_STRING && strcmp(over->string, "t") == 0;
  if (out->type != KM_MODULE_MOTOR && (is_time || out->type != KM_MODULE_STIFFNESS))
    km_reader_error(reader, &at, "found it in a %s; expected a motor, or a joint of a stiffness",
                    km_module_type_word(out->type));
  if (is_time) {
    out->variable = KM_VARIABLE_TIME;
    return true;
  }
  km_module_input *input = KM_ARENA_NEW(&reader->model->arena, km_module_input, 1);
  int coordinate = km_reader_coordinate(reader, over, assembly, &at);
  if (!input || coordinate < 0)
    return coordinate != KM_LEFT_OUT;
  *input = (km_module_input){.port = {.coordinate = coordinate}, .weight = 1.0};
  out->variable = KM_VARIABLE_DISPLACEMENT;
  out->inputs = input;
  out->input_count = 1;
  out->input = input->port;
  if (!km_value_get(module, "output"))
    km_reader_error(reader, place, "\"output\" is missing; expected the joint or the frames on which the force acts");
  return true;
}

/* The law, if it is a curve. Over a joint, x counts in the file's unit of the joint. */
static void read_module_curve(km_reader *reader, const km_value *module, const km_place *place, km_model_module *out) {
  const char *const keys[] = {"over", "period", "interpolation", "cosine", "step", "expression", NULL};
  const bool over_joint = km_value_get(module, "over") && out->variable == KM_VARIABLE_DISPLACEMENT;
  if (!has_curve(module, out)) {
    for (const char *const *key = keys; *key && out->type <= KM_MODULE_MOTOR; ++key)
      if (km_value_get(module, *key)) {
        km_place at = {place, *key, 0};
        km_reader_error(reader, &at, "the module has no table, cosine or step; expected one of them");
      }
    return;
  }
  const bool is_other =
      km_value_get(module, "cosine") || km_value_get(module, "step") || km_value_get(module, "expression");
  km_place expression_at = {place, "expression", 0};
  if (km_value_get(module, "expression") && !km_value_get(module, "over") && out->variable != KM_VARIABLE_TIME)
    km_reader_error(reader, &expression_at, "a %s reads no time; expected a motor", km_module_type_word(out->type));
  if (is_other && (km_count_laws(module) > 1 || km_value_get(module, "coefficients"))) {
    km_reader_error(reader, place,
                    "found several laws; expected one of \"table\", \"cosine\", \"step\", \"expression\"");
    return;
  }
  double factor =
      over_joint && out->input_count ? km_model_coordinate_factor(reader->model, out->input.coordinate) : 1.0;
  km_read_curve(reader, module, factor, place, &out->curve);
}

static void read_module(km_reader *reader, const km_value *module, int assembly, const km_place *place) {
  if (!km_reader_active(module))
    return;
  km_reader_named(reader, module, place);
  const char *type = km_reader_string(module, "type");
  km_place type_at = {place, "type", 0};
  int type_found = km_module_type_find(type);
  if (type_found < 0)
    km_reader_error(reader, &type_at,
                    "\"%.40s\" is not a force module; expected stiffness, damping, friction, motor, pid, "
                    "fiala_tire or contact",
                    type);
  km_model_module def = {.name = km_reader_string(module, "name"),
                         .where = km_reader_where(reader, place),
                         .type = type_found < 0 ? KM_MODULE_STIFFNESS : (km_module_type)type_found};
  bool complete = read_inputs(reader, module, assembly, place, &def);
  complete = read_output(reader, module, assembly, place, &def) && complete;
  if (!complete) {
    km_reader_note(reader, place, "force module \"%.80s\" is left out with what it acts on",
                   km_reader_string(module, "name"));
    return;
  }
  read_law(reader, module, place, &def);
  read_variable(reader, module, place, &def);
  if (!read_over(reader, module, assembly, place, &def)) {
    km_reader_note(reader, place, "force module \"%.80s\" is left out with the joint that it reads",
                   km_reader_string(module, "name"));
    return;
  }
  read_module_curve(reader, module, place, &def);
  if (def.type == KM_MODULE_TIRE)
    read_tire(reader, module, place, &def.tire);
  if (def.type == KM_MODULE_CONTACT)
    read_contact(reader, module, place, &def.contact);
  reader->origin->modules[reader->model->module_count] = module;
  reader->model->modules[reader->model->module_count++] = def;
  if (def.input_count == 0)
    km_reader_error(reader, place, "\"input\" is missing; expected where the force module acts");
  check_law(reader, module, type, has_curve(module, &def), place);
  check_pieces(reader, module, place);
  warn_unused_laws(reader, module, &def, place);
}

static void modules_of(km_reader *reader, const km_value *assembly, int index, const km_place *place) {
  km_reader_each(reader, assembly, "force_modules", index, place, read_module);
}

void km_read_force_modules(km_reader *reader, const km_value *root) {
  if (!reader->model->arena.failed)
    km_reader_visit(reader, root, modules_of);
}
