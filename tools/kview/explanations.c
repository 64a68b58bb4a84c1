/* Explanations of a motion: null space, redundant constraints, forces, mechanical advantage. */
#include "kview/messages.h"
#include "kview/server/time_limit.h"

#include "kmech/mobility.h"
#include "kmech/statics.h"

#include <stdlib.h>

enum { MOST_MOTIONS = 12, MOST_BASIS = 2000 };

/* One motion: rates of the coordinates, and the twist of every body at its own frame. */
static void add_motion(const kv_session *s, const double *rates, km_text *out) {
  int bodies = km_model_body_count(s->model) + 1;
  km_error error;
  kv_add_comma(out);
  km_text_add(out, "{\"rates\":");
  kv_add_numbers(out, rates, km_model_coordinate_count(s->model));
  km_text_add(out, ",\"twists\":[");
  for (int b = 0; b < bodies; ++b) {
    double twist[6] = {0};
    km_frame_twist(s->mechanism, s->state, s->origin[b], rates, twist, &error);
    kv_add_comma(out);
    kv_add_numbers(out, twist, 6);
  }
  km_text_add(out, "]}");
}

/* motions: a basis of the instantaneous motions. */
km_status kv_motions(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  int n = km_model_coordinate_count(s->model), freedom = 0;
  if (n > MOST_BASIS)
    return km_fail(error, KM_USAGE, "motions are shown of up to %d coordinates", MOST_BASIS);
  double *N = calloc((size_t)n * (size_t)n + 1, sizeof *N);
  km_status status =
      N ? km_motions_basis(s->mechanism, s->state, N, &freedom, error) : km_fail(error, KM_MEMORY, "out of memory");
  if (!status) {
    km_text_format(&call->answer->bytes, "{\"kind\":\"motions\",\"request\":%u,\"freedom\":%d,\"motions\":[",
                   call->request, freedom);
    for (int k = 0; k < freedom && k < MOST_MOTIONS; ++k)
      add_motion(s, N + (size_t)k * (size_t)n, &call->answer->bytes);
    km_text_add(&call->answer->bytes, "]}");
  }
  free(N);
  return status;
}

static void add_redundancy(const kv_session *s, const km_redundancy *r, km_text *out) {
  kv_add_comma(out);
  km_text_format(out, "{\"rotation\":%s,\"loop\":%d,\"loops\":%d,\"outOfPlane\":%s,\"lasting\":%s,\"direction\":",
                 r->rotation ? "true" : "false", r->loop, r->loops, r->out_of_plane ? "true" : "false",
                 r->persistent ? "true" : "false");
  kv_add_numbers(out, r->direction, 3);
  km_text_add(out, ",\"point\":");
  kv_add_numbers(out, r->point, 3);
  km_text_add(out, ",\"remedies\":[");
  for (int i = 0; i < r->remedy_count; ++i) {
    kv_add_comma(out);
    km_text_add(out, "{\"joint\":");
    kv_add_string(out, km_model_joint_label(s->model, r->remedies[i].joint));
    km_text_format(out, ",\"index\":%d,\"to\":", r->remedies[i].joint);
    kv_add_string(out, r->remedies[i].to);
    km_text_add(out, "}");
  }
  km_text_add(out, "]}");
}

/* diagnose: redundant constraints with their remedies, and the finite mobility. */
km_status kv_diagnose(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  km_text *out = &call->answer->bytes;
  km_redundancies redundancies = {0};
  km_finite_mobility finite = {0};
  kv_limit limit = kv_limit_begin();
  km_status status = kv_session_probe(s, error);
  km_mobility mobility;
  if (!status) {
    km_poses_compute(s->mechanism, s->probe);
    status = km_mobility_compute(s->mechanism, s->probe, &mobility);
    if (status)
      km_fail(error, status, "out of memory for the mobility");
  }
  if (!status) {
    status = km_redundancies_find(s->mechanism, s->probe, kv_limit_goes_on, &limit, &redundancies, error);
  }
  if (!status)
    status = km_finite_mobility_find(s->mechanism, s->probe, kv_limit_goes_on, &limit, &finite, error);
  status = kv_limit_report(status, "the diagnosis", error);
  if (!status) {
    km_text_format(out, "{\"kind\":\"diagnosis\",\"request\":%u,\"finite\":%d,\"undecided\":%s,\"redundancies\":[",
                   call->request, finite.mobility, finite.undecided ? "true" : "false");
    for (int i = 0; i < redundancies.count; ++i)
      add_redundancy(s, &redundancies.items[i], out);
    km_text_add(out, "]}");
  }
  km_redundancies_free(&redundancies);
  km_finite_mobility_free(&finite);
  return status;
}

static void add_loads(const kv_session *s, km_text *out) {
  km_text_add(out, ",\"loads\":[");
  for (int i = 0; i < km_model_load_count(s->model); ++i) {
    km_load load = km_model_load_at(s->model, i);
    km_frame_pose X;
    double force[3];
    km_error error;
    if (km_frame_place(s->mechanism, s->state, load.frame, &X, &error))
      continue;
    for (int k = 0; k < 3; ++k)
      force[k] = !load.turning
                     ? load.force[k]
                     : X.R[3 * k] * load.force[0] + X.R[3 * k + 1] * load.force[1] + X.R[3 * k + 2] * load.force[2];
    kv_add_comma(out);
    km_text_add(out, "{\"name\":");
    kv_add_string(out, km_model_load_name(s->model, i));
    km_text_add(out, ",\"point\":");
    kv_add_numbers(out, X.p, 3);
    km_text_add(out, ",\"force\":");
    kv_add_numbers(out, force, 3);
    km_text_add(out, "}");
  }
  km_text_add(out, "]");
}

static void add_balance(const kv_session *s, const km_statics *statics, km_text *out) {
  km_text_format(out, ",\"held\":%s,\"degree\":%d,\"actuators\":[", statics->held ? "true" : "false", statics->degree);
  for (int i = 0; i < statics->actuator_count; ++i) {
    kv_add_comma(out);
    km_text_format(out, "{\"coordinate\":%d,\"force\":", statics->actuators[i].coordinate);
    kv_add_number(out, statics->actuator_forces[i]);
    km_text_add(out, "}");
  }
  km_text_add(out, "],\"leastNorm\":");
  kv_add_numbers(out, statics->least_norm, km_model_coordinate_count(s->model));
  km_text_add(out, ",\"reactions\":[");
  for (int j = 0; j < km_model_joint_count(s->model); ++j) {
    double point[3];
    km_frame_position(s->mechanism, s->state, km_model_joint_frame(s->model, j, true), point);
    kv_add_comma(out);
    km_text_add(out, "{\"point\":");
    kv_add_numbers(out, point, 3);
    km_text_add(out, ",\"force\":");
    kv_add_numbers(out, statics->reactions[j].force, 3);
    km_text_add(out, ",\"torque\":");
    kv_add_numbers(out, statics->reactions[j].torque, 3);
    km_text_add(out, "}");
  }
  km_text_add(out, "]}");
}

/* The model's actuators; NULL with *count 0: it names none. */
static int *actuators_of(const km_model *model, int *count) {
  *count = km_model_actuator_count(model);
  int *list = malloc((size_t)(*count + 1) * sizeof *list);
  for (int i = 0; list && i < *count; ++i)
    list[i] = km_model_actuator(model, i);
  return list;
}

/* forces: loads, the actuators' forces and reactions that hold the pose. */
km_status kv_forces(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  km_forces *forces = NULL;
  km_statics statics = {0};
  int count;
  int *actuators = actuators_of(s->model, &count), loads = km_model_load_count(s->model);
  km_load *load = calloc((size_t)loads + 1, sizeof *load);
  km_status status = actuators && load ? KM_OK : km_fail(error, KM_MEMORY, "out of memory");
  for (int i = 0; i < loads && !status; ++i)
    load[i] = km_model_load_at(s->model, i);
  if (!status)
    status = km_forces_create(s->mechanism, NULL, load, loads, &forces, error);
  if (!status)
    status = km_statics_create(s->mechanism, count ? actuators : NULL, count, KM_AXES_FIXED, &statics, error);
  if (!status && km_statics_compute(s->mechanism, s->state, forces, &statics) == KM_MEMORY)
    status = km_fail(error, KM_MEMORY, "out of memory");
  if (!status) {
    km_text_format(&call->answer->bytes, "{\"kind\":\"forces\",\"request\":%u", call->request);
    add_loads(s, &call->answer->bytes);
    add_balance(s, &statics, &call->answer->bytes);
  }
  km_statics_free(&statics);
  km_forces_free(forces);
  free(load);
  free(actuators);
  return status;
}

/* lever INPUT OUTPUT: mechanical advantage of two coordinates. */
km_status kv_lever(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  km_port ends[2];
  km_transfer *lever = NULL;
  km_advantage advantage;
  for (int k = 0; k < 2; ++k) {
    int coordinate = kv_index(call, k);
    ends[k] = (km_port){.kind = KM_PORT_JOINT, .coordinate = coordinate};
    ends[k].name = km_model_coordinate_label(s->model, coordinate);
  }
  km_status status = km_transfer_create(s->mechanism, &ends[0], &ends[1], &lever, error);
  if (!status && km_transfer_compute(s->mechanism, s->state, lever, &advantage) == KM_MEMORY)
    status = km_fail(error, KM_MEMORY, "out of memory for the leverage");
  if (!status) {
    km_text_format(&call->answer->bytes, "{\"kind\":\"lever\",\"request\":%u,\"state\":\"%s\",\"unit\":", call->request,
                   km_advantage_state_name(advantage.state));
    kv_add_string(&call->answer->bytes, km_advantage_unit(s->model, &ends[0], &ends[1]));
    km_text_add(&call->answer->bytes, ",\"value\":");
    kv_add_number(&call->answer->bytes, advantage.value);
    km_text_add(&call->answer->bytes, "}");
  }
  km_transfer_free(lever);
  return status;
}
