/* The tools' defaults for a model, and the loads on it: checked and kept. */
#include "exchange/json/read/reader.h"
#include "model/name_path.h"

#include <math.h>
#include <string.h>

/* Coordinate named in `analysis`; −1 for an inactive element. */
static int analysis_coordinate(km_reader *reader, const km_value *path, const km_place *place) {
  char text[KM_PLACE_TEXT];
  int coordinate = km_reader_coordinate(reader, path, KM_NO_ASSEMBLY, place);
  if (coordinate == KM_LEFT_OUT)
    km_reader_note(reader, place, "joint \"%s\" is left out of the model, and what is asked of it with it",
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

/* Factor of a load over a joint's value or time. */
static const km_load_scale *read_scale(km_reader *reader, const km_value *scale, const km_place *place) {
  const km_value *over = km_value_get(scale, "over");
  km_place over_at = {place, "over", 0};
  int laws = km_count_laws(scale);
  km_load_scale *out = KM_ARENA_NEW(&reader->model->arena, km_load_scale, 1);
  if (laws != 1)
    km_reader_error(reader, place,
                    "found %d laws; expected one of \"table\", \"cosine\", \"step\", \"polynomial\", "
                    "\"expression\"",
                    laws);
  if (!out || laws != 1)
    return NULL;
  bool is_time = !over || (over->kind == KM_STRING && strcmp(over->string, "t") == 0);
  out->coordinate = is_time ? -1 : analysis_coordinate(reader, over, &over_at);
  if (!is_time && out->coordinate < 0)
    return NULL;
  km_read_curve(reader, scale, is_time ? 1.0 : km_model_coordinate_factor(reader->model, out->coordinate), place,
                &out->curve);
  return out;
}

static void read_load(km_reader *reader, const km_value *value, int owner, const km_place *place) {
  (void)owner;
  km_model *model = reader->model;
  km_reader_named(reader, value, place);
  km_place at = {place, "frame", 0}, axes_at = {place, "axes", 0}, scale_at = {place, "scale", 0};
  const km_value *scale = km_value_get(value, "scale");
  const char *axes = km_reader_string(value, "axes");
  if (axes && strcmp(axes, "fixed") != 0 && strcmp(axes, "frame") != 0)
    km_reader_error(reader, &axes_at, "\"%.40s\" is not known; expected \"fixed\" or \"frame\"", axes);
  int frame = km_reader_frame_anywhere(reader, km_value_get(value, "frame"), &at, "the load");
  if (frame == KM_LEFT_OUT)
    return;
  model->loads[model->load_count++] = (km_applied_load){.name = km_reader_string(value, "name"),
                                                        .frame = frame < 0 ? 0 : frame,
                                                        .force = km_reader_vector(value, "force"),
                                                        .torque = km_reader_vector(value, "torque"),
                                                        .turning = axes && strcmp(axes, "frame") == 0,
                                                        .scale = scale ? read_scale(reader, scale, &scale_at) : NULL};
}

/* One entry of `hold`: every coordinate of a joint, or one coordinate of it. */
static void read_hold(km_reader *reader, const km_value *value, const km_place *place) {
  km_model *model = reader->model;
  const km_value *item;
  int first, freedom = km_reader_values(reader, value, place, &first, &item);
  for (int h = 0; h < model->hold_count; ++h) {
    if (model->holds[h].coordinate >= first && model->holds[h].coordinate < first + freedom) {
      km_reader_error(reader, place, "this coordinate is held twice; expected each once");
      return;
    }
  }
  for (int k = 0; k < freedom; ++k, item = item->next)
    model->holds[model->hold_count++] = (km_model_hold){first + k, item->number};
}

/* The components of a rotation vector can be held only together. */
static void check_held_balls(km_reader *reader, const km_place *place) {
  const km_model *model = reader->model;
  for (int h = 0; h < model->hold_count; ++h) {
    int coordinate = model->holds[h].coordinate, joint = model->coordinates[coordinate].joint, together = 0;
    if (!km_model_turns(reader->model, coordinate))
      continue;
    for (int k = 0; k < model->hold_count; ++k)
      together += model->coordinates[model->holds[k].coordinate].joint == joint &&
                  km_model_turns(reader->model, model->holds[k].coordinate);
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
  if (coordinate >= 0)
    model->actuators[model->actuator_count++] = coordinate;
}

/* {"frame": path, "direction": [x, y, z]}: a point of a body along a direction. */
static km_model_port read_point(km_reader *reader, const km_value *value, const km_place *place) {
  km_model_port handle = {-1, -1, {0, 0, 0}, NULL};
  const km_value *frame = km_value_get(value, "frame"), *direction = km_value_get(value, "direction");
  km_place frame_at = {place, "frame", 0}, direction_at = {place, "direction", 0};
  bool vector = direction && direction->kind == KM_LIST && (direction->count == 2 || direction->count == 3);
  for (const km_value *v = vector ? direction->first : NULL; v; v = v->next)
    vector = vector && v->kind == KM_NUMBER;
  if (!frame || !vector) {
    km_reader_error(reader, place, "expected a joint, or a point of a body as \"frame\" and \"direction\" [x, y, z]");
    return handle;
  }
  handle.frame = km_reader_frame_anywhere(reader, frame, &frame_at, "the end of the leverage");
  handle.direction = km_reader_vector(value, "direction");
  if (km_vec3_norm(handle.direction) == 0.0)
    km_reader_error(reader, &direction_at, "found no length; expected a direction");
  handle.frame = handle.frame < 0 ? -1 : handle.frame;
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

static km_model_port read_handle(km_reader *reader, const km_value *value, const km_place *place) {
  km_model_port none = {-1, -1, {0, 0, 0}, NULL};
  if (!value)
    return none;
  if (value->kind == KM_OBJECT)
    return read_point(reader, value, place);
  bool names = value->kind == KM_STRING || (value->kind == KM_LIST && value->first);
  for (const km_value *v = value->kind == KM_LIST ? value->first : NULL; v; v = v->next)
    names = names && v->kind == KM_STRING;
  if (names)
    return (km_model_port){analysis_coordinate(reader, value, place), -1, {0, 0, 0}, NULL};
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
  model->advantage_input = model->advantage_output = (km_model_port){-1, -1, {0, 0, 0}, NULL};
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
