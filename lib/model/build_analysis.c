/* Models by calls: force modules, loads, actuators, held coordinates, named poses, default analyses. */
#include "model/builder.h"

#include <stdio.h>
#include <string.h>

/* Copies knots and pieces. */
static km_status copy_law(km_builder *b, const km_force_def *def, const char *who, km_law *out, km_error *error) {
  size_t total = 0;
  if (def->knot_count < 0 || (def->knot_count > 0 && !def->knots) || (def->coefficients && !def->piece_sizes))
    return km_fail(error, KM_MODEL, "%s: the law is not complete; expected knots, and a size for each piece", who);
  for (int i = 1; i < def->knot_count; ++i)
    if (!(def->knots[i] > def->knots[i - 1]))
      return km_fail(error, KM_MODEL, "%s: found %g after %g; expected increasing knots", who, def->knots[i],
                     def->knots[i - 1]);
  int *start = KM_ARENA_NEW(&b->model->arena, int, (size_t)def->knot_count + 2);
  for (int i = 0; start && def->coefficients && i <= def->knot_count; ++i) {
    if (def->piece_sizes[i] < 0)
      return km_fail(error, KM_MODEL, "%s: a piece has %d coefficients; expected at least 0", who, def->piece_sizes[i]);
    total += (size_t)def->piece_sizes[i];
    start[i + 1] = (int)total;
  }
  if (total > 0 && !km_builder_sane(def->coefficients, total))
    return km_fail(error, KM_MODEL, "%s: found a coefficient that is not finite", who);
  *out = (km_law){def->knot_count, km_builder_numbers(b, def->knots, (size_t)def->knot_count), start,
                  km_builder_numbers(b, def->coefficients, total)};
  return b->model->arena.failed ? km_builder_memory(error) : KM_OK;
}

/* Finds the coordinate or frames at which a force measures and acts. */
static bool find_port(const km_builder *b, const km_force_def *def, const char *who, km_module_port *out,
                      km_error *error) {
  *out = (km_module_port){KM_MODULE_PORT_FRAMES, {0, 0}};
  if (def->coordinate.joint.value)
    return km_builder_coordinate(b, def->coordinate, who, &out->coordinate, error);
  return km_builder_frame(b, def->from, who, &out->frame[0], error) &&
         km_builder_frame(b, def->to, who, &out->frame[1], error);
}

static bool is_lawless(const km_force_def *def) {
  bool pieces = def->type == KM_MODULE_STIFFNESS || def->type == KM_MODULE_DAMPING || def->type == KM_MODULE_FRICTION ||
                def->type == KM_MODULE_MOTOR;
  return pieces && !def->coefficients;
}

km_status km_model_add_force(km_builder *b, const km_force_def *def, km_error *error) {
  const char *name;
  char who[120];
  if (!b || !b->model || !def || def->type < 0 || def->type >= KM_MODULE_TYPES || def->distance < 0 ||
      def->distance > KM_DISTANCE_RZ || is_lawless(def))
    return km_fail(error, KM_MODEL, "force \"%.80s\": found no builder, a type that isn't one, or no law",
                   def && def->name ? def->name : "");
  km_status status = km_builder_name(b, "force", def->name, NULL, 0, NULL, &name, error);
  if (status)
    return status;
  snprintf(who, sizeof who, "force \"%.80s\"", name);
  km_model_module module = {.name = name,
                            .where = name,
                            .type = def->type,
                            .distance = def->distance,
                            .variable = km_module_type_variable(def->type),
                            .input_count = 1,
                            .kp = def->kp,
                            .ki = def->ki,
                            .kd = def->kd};
  if (!find_port(b, def, who, &module.input, error))
    return KM_MODEL;
  module.output = module.input;
  module.inputs = km_model_single_input(&b->model->arena, module.input, def->distance);
  module.reference = km_curve_constant(&b->model->arena, def->reference);
  if (!module.inputs || !module.reference.numbers)
    return km_builder_memory(error);
  status = copy_law(b, def, who, &module.law, error);
  if (status)
    return status;
  if (!KM_BUILDER_GROW(b, modules, module_room, module_count))
    return km_builder_memory(error);
  b->model->modules[b->model->module_count++] = module;
  return KM_OK;
}

km_status km_model_add_load(km_builder *b, const km_load_def *def, km_error *error) {
  const char *name;
  char who[120];
  int frame;
  if (!b || !b->model || !def || !km_builder_sane(def->force, 3) || !km_builder_sane(def->torque, 3))
    return km_fail(error, KM_MODEL, "load \"%.80s\": expected finite forces and torques",
                   def && def->name ? def->name : "");
  km_status status = km_builder_name(b, "load", def->name, NULL, 0, NULL, &name, error);
  if (status)
    return status;
  snprintf(who, sizeof who, "load \"%.80s\"", name);
  if (!km_builder_frame(b, def->frame, who, &frame, error))
    return KM_MODEL;
  if (!KM_BUILDER_GROW(b, loads, load_room, load_count))
    return km_builder_memory(error);
  b->model->loads[b->model->load_count++] = (km_applied_load){.name = name,
                                                              .frame = frame,
                                                              .force = km_vec3_from_array(def->force),
                                                              .torque = km_vec3_from_array(def->torque),
                                                              .turning = def->turning};
  return KM_OK;
}

km_status km_model_add_hold(km_builder *b, km_coordinate_ref coordinate, double value, km_error *error) {
  int c;
  if (!b || !b->model || !km_builder_sane(&value, 1))
    return km_fail(error, KM_MODEL, "a hold: found no builder, or a value that is not finite");
  if (!km_builder_coordinate(b, coordinate, "a hold", &c, error))
    return KM_MODEL;
  for (int h = 0; h < b->model->hold_count; ++h)
    if (b->model->holds[h].coordinate == c)
      return km_fail(error, KM_MODEL, "a hold: this coordinate is held twice; expected each once");
  if (!KM_BUILDER_GROW(b, holds, hold_room, hold_count))
    return km_builder_memory(error);
  b->model->holds[b->model->hold_count++] = (km_model_hold){c, value};
  return KM_OK;
}

km_status km_model_add_pose(km_builder *b, const char *name, const km_coordinate_ref *coordinates, const double *values,
                            int count, km_error *error) {
  const char *copy;
  if (!b || !b->model || count < 0 || (count > 0 && (!coordinates || !values)) ||
      !km_builder_sane(values, (size_t)count))
    return km_fail(error, KM_MODEL, "pose \"%.80s\": found no builder, or a value that is not finite",
                   name ? name : "");
  km_status status = km_builder_name(b, "pose", name, NULL, 0, NULL, &copy, error);
  for (int i = 0; i < b->model->pose_count && !status; ++i)
    if (strcmp(b->model->poses[i].name, copy) == 0)
      status = km_fail(error, KM_MODEL, "pose \"%.80s\": this name is used twice; expected a name of its own", copy);
  if (status)
    return status;
  int *list = KM_ARENA_NEW(&b->model->arena, int, (size_t)count);
  double *numbers = km_builder_numbers(b, values, (size_t)count);
  if (b->model->arena.failed || !KM_BUILDER_GROW(b, poses, pose_room, pose_count))
    return km_builder_memory(error);
  for (int k = 0; k < count; ++k)
    if (!km_builder_coordinate(b, coordinates[k], "a pose", &list[k], error))
      return KM_MODEL;
  b->model->poses[b->model->pose_count++] = (km_model_pose){copy, count, list, numbers};
  return KM_OK;
}

km_status km_model_add_actuator(km_builder *b, km_coordinate_ref coordinate, km_error *error) {
  int c;
  if (!b || !b->model)
    return km_fail(error, KM_USAGE, "found no builder");
  if (!km_builder_coordinate(b, coordinate, "an actuator", &c, error))
    return KM_MODEL;
  for (int a = 0; a < b->model->actuator_count; ++a)
    if (b->model->actuators[a] == c)
      return km_fail(error, KM_MODEL, "an actuator: this coordinate is named twice; expected each once");
  if (!KM_BUILDER_GROW(b, actuators, actuator_room, actuator_count))
    return km_builder_memory(error);
  b->model->actuators_given = true;
  b->model->actuators[b->model->actuator_count++] = c;
  return KM_OK;
}

km_status km_model_set_sweep(km_builder *b, const km_sweep_def *def, km_error *error) {
  if (!b || !b->model || !def)
    return km_fail(error, KM_USAGE, "found no builder or no sweep");
  bool driven = def->driver.joint.value != 0;
  const double numbers[3] = {def->from, def->to, def->arclength};
  if (driven == (def->arclength > 0.0) || !km_builder_sane(numbers, 3) || def->steps < 1 || def->steps > 10000000 ||
      def->sign == 0.0)
    return km_fail(error, KM_MODEL,
                   "a sweep: expected either a driver with a range or an arc length greater than 0, 1 to 10000000 "
                   "steps, and a sign of +1 or -1");
  km_model_sweep sweep = {.coordinate = -1,
                          .range = {def->from, def->to},
                          .arclength = driven ? 0.0 : def->arclength,
                          .direction = -1,
                          .sign = def->sign < 0.0 ? -1.0 : 1.0,
                          .steps = def->steps};
  if (driven && !km_builder_coordinate(b, def->driver, "a sweep", &sweep.coordinate, error))
    return KM_MODEL;
  if (def->direction.joint.value && !km_builder_coordinate(b, def->direction, "a sweep", &sweep.direction, error))
    return KM_MODEL;
  b->model->sweep = sweep;
  return KM_OK;
}

/* A port of the model. The name of a point states body, frame and direction. */
static km_status find_end(km_builder *b, const km_end_def *def, km_model_port *out, km_error *error) {
  static const char who[] = "a mechanical advantage";
  *out = (km_model_port){-1, -1, km_vec3_from_array(def->direction), NULL};
  if (def->coordinate.joint.value) {
    out->direction = (km_vec3){0, 0, 0};
    return km_builder_coordinate(b, def->coordinate, who, &out->coordinate, error) ? KM_OK : KM_MODEL;
  }
  if (!km_builder_frame(b, def->frame, who, &out->frame, error))
    return KM_MODEL;
  if (!km_builder_sane(def->direction, 3) || km_vec3_norm(out->direction) == 0.0)
    return km_fail(error, KM_MODEL, "%s: expected a direction with a length", who);
  const km_model_frame *frame = &b->model->frames[out->frame];
  km_text name = {0};
  km_text_format(&name, "%s/%s:%g,%g,%g", b->model->bodies[frame->body].name, frame->name, out->direction.x,
                 out->direction.y, out->direction.z);
  out->name = name.failed ? NULL : km_arena_string(&b->model->arena, name.data);
  km_text_free(&name);
  return out->name ? KM_OK : km_builder_memory(error);
}

km_status km_model_set_advantage(km_builder *b, const km_end_def *input, const km_end_def *output, km_error *error) {
  km_model_port from, to;
  if (!b || !b->model || !input || !output)
    return km_fail(error, KM_USAGE, "found no builder, no input or no output");
  km_status status = find_end(b, input, &from, error);
  if (!status)
    status = find_end(b, output, &to, error);
  if (!status && from.coordinate >= 0 && from.coordinate == to.coordinate)
    status = km_fail(error, KM_MODEL, "a mechanical advantage: the output is the input too; expected another one");
  if (status)
    return status;
  b->model->advantage_input = from;
  b->model->advantage_output = to;
  return KM_OK;
}
