/* Ports (input, output) of a mechanism: defaults of the model, checks, units and names. */
#include "base/arguments.h"
#include "transfer/transfer.h"

#include <string.h>

bool km_port_default(const km_model *model, bool output, km_port *out) {
  if (!out)
    return false;
  *out = (km_port){0};
  if (!model)
    return false;
  const km_model_port *d = output ? &model->advantage_output : &model->advantage_input;
  double length = km_vec3_norm(d->direction);
  km_port_kind kind = d->coordinate >= 0 ? KM_PORT_JOINT : d->frame >= 0 ? KM_PORT_POINT : KM_PORT_NONE;
  *out = (km_port){.kind = kind, .coordinate = d->coordinate, .frame = d->frame, .name = d->name};
  if (kind == KM_PORT_JOINT)
    out->name = model->coordinates[d->coordinate].label;
  if (kind == KM_PORT_POINT) {
    out->direction[0] = d->direction.x / length;
    out->direction[1] = d->direction.y / length;
    out->direction[2] = d->direction.z / length;
  }
  return kind != KM_PORT_NONE;
}

const char *km_end_word(bool output) {
  return output ? "output" : "input";
}

static km_status check_port(const km_mechanism *m, const km_port *h, bool output, km_error *error) {
  km_status status = km_check_given(h != NULL, km_end_word(output), error);
  if (status)
    return status;
  if (h->kind == KM_PORT_JOINT)
    return km_check_index(h->coordinate, m->coordinate_count, "coordinate", error);
  if (h->kind != KM_PORT_POINT)
    return km_fail(error, KM_USAGE, "the %s is neither a joint nor a point", km_end_word(output));
  double length = km_vec3_norm(km_vec3_from_array(h->direction));
  if (!(length > 0.0 && isfinite(length)))
    return km_fail(error, KM_USAGE, "the %s is a point without a direction", km_end_word(output));
  return km_check_index(h->frame, m->model->frame_count, "frame", error);
}

km_status km_check_ports(const km_mechanism *m, const km_port *input, const km_port *output, km_error *error) {
  km_status status = km_check_given(m != NULL, "mechanism", error);
  if (!status)
    status = check_port(m, input, false, error);
  return status ? status : check_port(m, output, true, error);
}

km_status km_unit_load_create(const km_mechanism *m, const km_port *input, const km_port *output, km_forces **forces,
                              km_statics *statics, km_error *error) {
  const double *d = output->direction;
  const km_load load = {.frame = output->frame, .force = {-d[0], -d[1], -d[2]}};
  km_status status = km_forces_create_loads_only(m, &load, output->kind == KM_PORT_POINT, forces, error);
  if (!status)
    status = km_statics_create(m, &input->coordinate, input->kind == KM_PORT_JOINT, KM_AXES_FIXED, statics, error);
  if (!status && output->kind == KM_PORT_JOINT)
    (*forces)->extra[output->coordinate] = -1.0;
  return status;
}

static bool is_angle(const km_model *model, const km_port *h) {
  return h->kind == KM_PORT_JOINT && h->coordinate >= 0 && h->coordinate < model->coordinate_count &&
         !km_model_coordinate_is_length(model, h->coordinate);
}

const char *km_advantage_unit(const km_model *model, const km_port *input, const km_port *output) {
  if (!model || !input || !output)
    return "";
  static const char *const over[4] = {"rad/m", "rad/mm", "rad/cm", "rad/in"}, *const under[4] = {"m/rad", "mm/rad",
                                                                                                 "cm/rad", "in/rad"};
  bool in = is_angle(model, input), out = is_angle(model, output);
  for (int i = 0; i < 4 && in != out; ++i)
    if (strcmp(model->units.length->suffix, over[i] + 4) == 0)
      return in ? over[i] : under[i];
  return "";
}

const char *km_advantage_state_name(km_advantage_state state) {
  static const char *const names[] = {"finite", "zero", "infinite", "undefined"};
  return (size_t)state < sizeof names / sizeof *names ? names[state] : "";
}

const char *km_advantage_method_name(km_advantage_method method) {
  static const char *const names[] = {"single freedom", "least motion"};
  return (size_t)method < sizeof names / sizeof *names ? names[method] : "";
}
