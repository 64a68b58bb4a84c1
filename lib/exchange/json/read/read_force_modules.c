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

/* Knots and polynomials; a motor's polynomial in time is one without knots. */
static void read_law(km_reader *reader, const km_value *module, km_model_module *out) {
  const km_value *pieces = km_value_get(module, "coefficients"), *polynomial = km_value_get(module, "polynomial");
  size_t knots, total, rows;
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
  out->table = numbers_of(reader, km_value_get(module, "table"), &rows);
  out->table_count = (int)(rows / 2);
  out->reference = km_reader_number(module, "reference", 0.0);
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

/* False where the port names what is left out. */
static bool read_port(km_reader *reader, const km_value *port, int assembly, const km_place *place,
                      km_module_port *out) {
  const char *type = km_reader_string(port, "type");
  const km_value *joint = km_value_get(port, "joint"), *pair = km_value_get(port, "body_frame_pair");
  km_place type_at = {place, "type", 0}, joint_at = {place, "joint", 0}, pair_at = {place, "body_frame_pair", 0};
  *out = (km_module_port){KM_MODULE_PORT_FRAMES, {0, 0}};
  if (strcmp(type, "joint") == 0) {
    if (joint)
      out->coordinate = km_reader_coordinate(reader, joint, assembly, &joint_at);
    else
      km_reader_error(reader, place, "\"joint\" is missing; expected the joint of this port");
    return out->coordinate != KM_LEFT_OUT;
  }
  if (strcmp(type, "frame") != 0) {
    km_reader_error(reader, &type_at, "\"%.40s\" is not a kind of port; expected \"joint\" or \"frame\"", type);
  } else if (!pair) {
    km_reader_error(reader, place, "\"body_frame_pair\" is missing; expected the two frames of this port");
  } else {
    km_place first = {&pair_at, NULL, 0}, second = {&pair_at, NULL, 1};
    out->frame[0] = km_reader_frame(reader, pair->first, assembly, &first);
    out->frame[1] = km_reader_frame(reader, pair->last, assembly, &second);
  }
  return out->frame[0] != KM_LEFT_OUT && out->frame[1] != KM_LEFT_OUT;
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
static void check_law(km_reader *reader, const km_value *module, const char *type, const km_place *place) {
  static const struct {
    const char *type, *keys[3], *words;
  } laws[] = {{"stiffness", {"coefficients"}, "\"coefficients\""},
              {"damping", {"coefficients"}, "\"coefficients\""},
              {"friction", {"coefficients"}, "\"coefficients\""},
              {"motor", {"polynomial", "table", "coefficients"}, "\"polynomial\" or \"table\""},
              {"pid", {"kp", "ki", "kd"}, "\"kp\", \"ki\" or \"kd\""}};
  for (size_t i = 0; i < sizeof laws / sizeof *laws; ++i) {
    bool given = strcmp(laws[i].type, type) != 0;
    for (size_t k = 0; k < 3 && laws[i].keys[k]; ++k)
      given = given || km_value_get(module, laws[i].keys[k]);
    if (!given)
      km_reader_error(reader, place, "%s is missing; expected the law of a %s", laws[i].words, type);
  }
}

/* One of several laws of a module is used: a motor's table before pieces, pieces before a polynomial. */
static void warn_unused_laws(km_reader *reader, const km_value *module, bool is_motor, const km_place *place) {
  km_place table = {place, "table", 0}, pieces = {place, "coefficients", 0}, polynomial = {place, "polynomial", 0};
  bool table_given = km_value_get(module, "table"), has_table = table_given && is_motor,
       has_pieces = km_value_get(module, "coefficients");
  if (table_given && !is_motor)
    km_reader_warning(reader, &table, "doesn't count: only motors have a table");
  if (has_table && has_pieces)
    km_reader_warning(reader, &pieces, "doesn't count: the motor has a table");
  if (km_value_get(module, "polynomial") && (has_table || has_pieces))
    km_reader_warning(reader, &polynomial, "doesn't count: the module has %s", has_table ? "a table" : "coefficients");
}

static void read_module(km_reader *reader, const km_value *module, int assembly, const km_place *place) {
  static const char *const distances[] = {"euclid", "Tx", "Ty", "Tz", NULL};
  if (!km_reader_active(module))
    return;
  km_reader_named(reader, module, place);
  const char *type = km_reader_string(module, "type"), *distance = km_reader_string(module, "distance_type");
  km_place type_at = {place, "type", 0}, distance_at = {place, "distance_type", 0};
  int type_found = km_module_type_find(type), distance_found = distance ? place_of(distance, distances) : 0;
  if (type_found < 0)
    km_reader_error(reader, &type_at,
                    "\"%.40s\" is not a force module; expected stiffness, damping, friction, motor, pid or fiala_tire",
                    type);
  if (distance_found < 0)
    km_reader_error(reader, &distance_at, "\"%.40s\" is not a distance; expected euclid, Tx, Ty or Tz", distance);
  const km_value *input = km_value_get(module, "input"), *output = km_value_get(module, "output");
  km_place input_at = {place, "input", 0}, output_at = {place, "output", 0};
  const km_value *either = input ? input : output;
  km_model_module def = {.name = km_reader_string(module, "name"),
                         .where = km_reader_where(reader, place),
                         .type = (km_module_type)type_found,
                         .distance = (km_distance)distance_found,
                         .input = {KM_MODULE_PORT_FRAMES, {0, 0}}};
  bool complete = !either || read_port(reader, either, assembly, input ? &input_at : &output_at, &def.input);
  def.output = def.input;
  if (input && output)
    complete = read_port(reader, output, assembly, &output_at, &def.output) && complete;
  if (!complete) {
    km_reader_note(reader, place, "force module \"%.80s\" is left out with what it acts on",
                   km_reader_string(module, "name"));
    return;
  }
  read_law(reader, module, &def);
  if (def.type == KM_MODULE_TIRE)
    read_tire(reader, module, place, &def.tire);
  reader->origin->modules[reader->model->module_count] = module;
  reader->model->modules[reader->model->module_count++] = def;
  if (!either)
    km_reader_error(reader, place, "\"input\" is missing; expected where the force module acts");
  check_law(reader, module, type, place);
  check_pieces(reader, module, place);
  warn_unused_laws(reader, module, def.type == KM_MODULE_MOTOR, place);
}

static void modules_of(km_reader *reader, const km_value *assembly, int index, const km_place *place) {
  km_reader_each(reader, assembly, "force_modules", index, place, read_module);
}

void km_read_force_modules(km_reader *reader, const km_value *root) {
  if (!reader->model->arena.failed)
    km_reader_visit(reader, root, modules_of);
}
