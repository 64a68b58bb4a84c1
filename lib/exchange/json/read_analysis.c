/* What acts on the mechanism (force modules, loads) and the tools' defaults: checked and kept. */
#include "exchange/json/path.h"
#include "exchange/json/reader.h"

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

/* False where the port names what is left out. */
static bool read_port(km_reader *reader, const km_value *port, int assembly, const km_place *place, km_port *out) {
  const char *type = km_reader_string(port, "type");
  const km_value *joint = km_value_get(port, "joint"), *pair = km_value_get(port, "body_frame_pair");
  km_place type_at = {place, "type", 0}, joint_at = {place, "joint", 0}, pair_at = {place, "body_frame_pair", 0};
  *out = (km_port){KM_PORT_FRAMES, {0, 0}};
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

/* What a type of force module can't do without: any one of the keys. */
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
                         .input = {KM_PORT_FRAMES, {0, 0}}};
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
  reader->origin->modules[reader->model->module_count] = module;
  reader->model->modules[reader->model->module_count++] = def;
  if (!either)
    km_reader_error(reader, place, "\"input\" is missing; expected where the force module acts");
  check_law(reader, module, type, place);
  check_pieces(reader, module, place);
}

static void modules_of(km_reader *reader, const km_value *assembly, int index, const km_place *place) {
  km_reader_each(reader, assembly, "force_modules", index, place, read_module);
}

void km_read_force_modules(km_reader *reader, const km_value *root) {
  if (!reader->model->arena.failed)
    km_reader_visit(reader, root, modules_of);
}

/* A coordinate named in `analysis`; what is left out can't be driven, held or asked for. */
static int analysis_coordinate(km_reader *reader, const km_value *path, const km_place *place) {
  char text[KM_PLACE_TEXT];
  int coordinate = km_reader_coordinate(reader, path, KM_NO_ASSEMBLY, place);
  if (coordinate == KM_LEFT_OUT)
    km_reader_error(reader, place, "joint \"%s\" is left out of the model; expected an active joint",
                    km_path_text(path, text));
  return coordinate < 0 ? -1 : coordinate;
}

static int read_steps(km_reader *reader, const km_value *sweep, const km_place *place) {
  double steps = km_reader_number(sweep, "steps", 100.0);
  km_place at = {place, "steps", 0};
  if (steps >= 1.0 && steps <= 1e7 && steps == floor(steps))
    return (int)steps;
  km_reader_error(reader, &at, "found %s; expected a whole number from 1 to 10000000", KM_SHOWN(steps));
  return 1;
}

static void read_sweep(km_reader *reader, const km_value *sweep, const km_place *place) {
  km_model_sweep *def = &reader->model->sweep;
  const km_value *joint = km_value_get(sweep, "joint"), *range = km_value_get(sweep, "range");
  const km_value *arclength = km_value_get(sweep, "arclength"), *direction = km_value_get(sweep, "direction");
  km_place joint_at = {place, "joint", 0}, arc_at = {place, "arclength", 0}, direction_at = {place, "direction", 0};
  km_place direction_joint = {&direction_at, "joint", 0};
  def->steps = read_steps(reader, sweep, place);
  if ((joint != NULL) == (arclength != NULL) || (joint && !range))
    km_reader_error(reader, place, "expected either \"joint\" with \"range\", or \"arclength\"");
  if (joint)
    def->coordinate = analysis_coordinate(reader, joint, &joint_at);
  if (range) {
    def->range[0] = range->first->number;
    def->range[1] = range->last->number;
  }
  if (arclength) {
    def->arclength = arclength->number;
    if (!(def->arclength > 0.0))
      km_reader_error(reader, &arc_at, "found %s; expected a length greater than 0", KM_SHOWN(def->arclength));
  }
  if (direction) {
    def->direction = analysis_coordinate(reader, km_value_get(direction, "joint"), &direction_joint);
    double sign = km_reader_number(direction, "sign", 1.0);
    km_place sign_at = {&direction_at, "sign", 0};
    if (sign == 0.0)
      km_reader_error(reader, &sign_at, "found 0; expected 1 or -1");
    def->sign = sign < 0.0 ? -1.0 : 1.0;
  }
}

/* A frame by its path from the root, or [body, frame] where the body is unique. */
static int analysis_frame(km_reader *reader, const km_value *path, const km_place *place) {
  km_path_names p;
  int frame = -1;
  km_error problem;
  km_path_names_gather(path, &p);
  if (km_model_find_frame(reader->model, p.names, p.count, &frame, &problem))
    km_reader_error(reader, place, "%s", problem.text);
  return frame;
}

static void read_load(km_reader *reader, const km_value *value, int owner, const km_place *place) {
  (void)owner;
  km_model *model = reader->model;
  km_reader_named(reader, value, place);
  km_place at = {place, "frame", 0}, axes_at = {place, "axes", 0};
  const char *axes = km_reader_string(value, "axes");
  if (axes && strcmp(axes, "fixed") != 0 && strcmp(axes, "frame") != 0)
    km_reader_error(reader, &axes_at, "\"%.40s\" is not known; expected \"fixed\" or \"frame\"", axes);
  int frame = analysis_frame(reader, km_value_get(value, "frame"), &at);
  model->loads[model->load_count++] = (km_applied_load){.name = km_reader_string(value, "name"),
                                                        .frame = frame < 0 ? 0 : frame,
                                                        .force = km_reader_vector(value, "force"),
                                                        .torque = km_reader_vector(value, "torque"),
                                                        .turning = axes && strcmp(axes, "frame") == 0};
}

/* One entry of `hold`: every coordinate of a joint, or one coordinate of it. */
static void read_hold(km_reader *reader, const km_value *value, const km_place *place) {
  km_model *model = reader->model;
  int coordinate = km_names_get(&reader->labels, KM_LABEL_COORDINATE, value->key);
  int joint = km_names_get(&reader->labels, KM_LABEL_JOINT, value->key);
  size_t given = value->kind == KM_LIST ? value->count : 1;
  const km_value *item = value->kind == KM_LIST ? value->first : value;
  size_t freedom = coordinate >= 0 ? 1 : joint >= 0 ? (size_t)km_model_freedom(model, joint) : 0;
  if (coordinate < 0 && joint < 0) {
    if (km_names_get(&reader->labels, KM_LABEL_FAULTY, value->key) < 0)
      km_reader_error(reader, place, "\"%.80s\" names no joint; expected a joint's label", value->key);
    return;
  }
  if (freedom != given) {
    km_reader_error(reader, place, "found %zu values; expected %zu", given, freedom);
    return;
  }
  int first = coordinate >= 0 ? coordinate : model->joints[joint].first_coordinate;
  for (int h = 0; h < model->hold_count; ++h) {
    if (model->holds[h].coordinate >= first && model->holds[h].coordinate < first + (int)freedom) {
      km_reader_error(reader, place, "this coordinate is held twice; expected each once");
      return;
    }
  }
  for (size_t k = 0; k < freedom; ++k, item = item->next)
    model->holds[model->hold_count++] = (km_model_hold){first + (int)k, item->number};
}

/* The components of a rotation vector can be held only together. */
static void check_held_balls(km_reader *reader, const km_place *place) {
  const km_model *model = reader->model;
  for (int h = 0; h < model->hold_count; ++h) {
    int coordinate = model->holds[h].coordinate, joint = model->coordinates[coordinate].joint, together = 0;
    if (!km_reader_turns(reader, coordinate))
      continue;
    for (int k = 0; k < model->hold_count; ++k)
      together += model->coordinates[model->holds[k].coordinate].joint == joint &&
                  km_reader_turns(reader, model->holds[k].coordinate);
    km_place at = {place, model->coordinates[coordinate].label, 0};
    if (together != 3)
      km_reader_error(reader, &at, "a component of a rotation vector; expected all of joint \"%s\" together, as a list",
                      model->joints[joint].label);
  }
}

static void read_actuator(km_reader *reader, const km_value *value, const km_place *place) {
  km_model *model = reader->model;
  int coordinate = analysis_coordinate(reader, value, place);
  for (int a = 0; a < model->actuator_count && coordinate >= 0; ++a)
    if (model->actuators[a] == coordinate)
      km_reader_error(reader, place, "this joint is named twice; expected each once");
  model->actuators[model->actuator_count++] = coordinate;
}

/* {"frame": path, "direction": [x, y, z]}: a point of a body along a direction. */
static km_model_handle read_point(km_reader *reader, const km_value *value, const km_place *place) {
  km_model_handle handle = {-1, -1, {0, 0, 0}, NULL};
  const km_value *frame = km_value_get(value, "frame"), *direction = km_value_get(value, "direction");
  km_place frame_at = {place, "frame", 0}, direction_at = {place, "direction", 0};
  bool vector = direction && direction->kind == KM_LIST && (direction->count == 2 || direction->count == 3);
  for (const km_value *v = vector ? direction->first : NULL; v; v = v->next)
    vector = vector && v->kind == KM_NUMBER;
  if (!frame || !vector) {
    km_reader_error(reader, place, "expected a joint, or a point of a body as \"frame\" and \"direction\" [x, y, z]");
    return handle;
  }
  handle.frame = analysis_frame(reader, frame, &frame_at);
  handle.direction = km_reader_vector(value, "direction");
  if (km_vec3_norm(handle.direction) == 0.0)
    km_reader_error(reader, &direction_at, "found no length; expected a direction");
  if (handle.frame >= 0) {
    const km_model_frame *def = &reader->model->frames[handle.frame];
    km_text name = {0};
    km_text_format(&name, "%s/%s:%g,%g,%g", reader->model->bodies[def->body].name, def->name, handle.direction.x,
                   handle.direction.y, handle.direction.z);
    handle.name = name.failed ? NULL : km_arena_string(&reader->model->arena, name.data);
    reader->model->arena.failed = reader->model->arena.failed || name.failed;
    km_text_free(&name);
  }
  return handle;
}

static km_model_handle read_handle(km_reader *reader, const km_value *value, const km_place *place) {
  km_model_handle none = {-1, -1, {0, 0, 0}, NULL};
  if (!value)
    return none;
  if (value->kind == KM_OBJECT)
    return read_point(reader, value, place);
  bool names = value->kind == KM_STRING || (value->kind == KM_LIST && value->first);
  for (const km_value *v = value->kind == KM_LIST ? value->first : NULL; v; v = v->next)
    names = names && v->kind == KM_STRING;
  if (names)
    return (km_model_handle){analysis_coordinate(reader, value, place), -1, {0, 0, 0}, NULL};
  if (value->kind == KM_NUMBER)
    km_reader_error(reader, place, "found %s; expected a joint", KM_SHOWN(value->number));
  else
    km_reader_error(reader, place, "found %s; expected a joint", km_kind_name(value->kind));
  return none;
}

/* Struts that are cylinders are actuators beside those that are listed. */
static void add_cylinders(km_reader *reader) {
  km_model *model = reader->model;
  for (int i = 0; i < reader->cylinder_count; ++i) {
    bool listed = false;
    for (int a = 0; a < model->actuator_count; ++a)
      listed = listed || model->actuators[a] == reader->cylinders[i];
    if (!listed)
      model->actuators[model->actuator_count++] = reader->cylinders[i];
    model->actuators_given = true;
  }
}

static void allocate(const km_reader *reader, const km_value *analysis) {
  km_model *model = reader->model;
  const km_value *actuators = km_value_get(analysis, "actuators"), *loads = km_value_get(analysis, "loads");
  model->actuators =
      KM_ARENA_NEW(&model->arena, int, (actuators ? actuators->count : 0) + (size_t)reader->cylinder_count);
  model->loads = KM_ARENA_NEW(&model->arena, km_applied_load, loads ? loads->count : 0);
  model->holds = KM_ARENA_NEW(&model->arena, km_model_hold, (size_t)model->coordinate_count);
}

void km_read_analysis(km_reader *reader, const km_value *root) {
  km_model *model = reader->model;
  const km_value *analysis = km_value_get(root, "analysis");
  model->sweep = (km_model_sweep){.coordinate = -1, .direction = -1, .sign = 1.0, .steps = 100};
  model->advantage_input = model->advantage_output = (km_model_handle){-1, -1, {0, 0, 0}, NULL};
  allocate(reader, analysis);
  model->actuators_given = km_value_get(analysis, "actuators") != NULL;
  if (model->arena.failed)
    return;
  if (!analysis) {
    add_cylinders(reader);
    return;
  }
  km_place place = {NULL, "analysis", 0};
  km_place sweep_at = {&place, "sweep", 0}, hold_at = {&place, "hold", 0}, actuators_at = {&place, "actuators", 0};
  km_place advantage_at = {&place, "mechanical_advantage", 0};
  km_place input_at = {&advantage_at, "input", 0}, output_at = {&advantage_at, "output", 0};
  const km_value *sweep = km_value_get(analysis, "sweep"), *hold = km_value_get(analysis, "hold");
  const km_value *actuators = km_value_get(analysis, "actuators");
  const km_value *advantage = km_value_get(analysis, "mechanical_advantage");
  if (sweep)
    read_sweep(reader, sweep, &sweep_at);
  km_place item = {&actuators_at, NULL, 0};
  for (const km_value *a = actuators ? actuators->first : NULL; a; a = a->next, ++item.index)
    read_actuator(reader, a, &item);
  add_cylinders(reader);
  model->advantage_input = read_handle(reader, km_value_get(advantage, "input"), &input_at);
  model->advantage_output = read_handle(reader, km_value_get(advantage, "output"), &output_at);
  if (model->advantage_input.coordinate >= 0 && model->advantage_input.coordinate == model->advantage_output.coordinate)
    km_reader_error(reader, &output_at, "is the input too; expected another joint or a point of a body");
  for (const km_value *h = hold ? hold->first : NULL; h; h = h->next) {
    km_place at = {&hold_at, h->key, 0};
    read_hold(reader, h, &at);
  }
  check_held_balls(reader, &hold_at);
  km_reader_each(reader, analysis, "loads", 0, &place, read_load);
}
