/* Figures of the cells of kspace map. */
#include "kspace/map_figures.h"

#include "kmech/data.h"
#include "kmech/dynamics.h"
#include "kmech/inspect.h"
#include "kmech/model.h"

#include <math.h>

static bool compute_advantage(void *context, const km_mechanism *mechanism, km_state *state, double *values) {
  kspace_map_figures *f = context;
  km_advantage advantage;
  bool is_ok = km_transfer_compute(mechanism, state, f->transfer, &advantage) == KM_OK;
  values[0] = advantage.value;
  return is_ok;
}

static bool compute_forces(void *context, const km_mechanism *mechanism, km_state *state, double *values) {
  kspace_map_figures *f = context;
  bool is_ok = km_statics_compute(mechanism, state, f->forces, &f->statics) != KM_MEMORY;
  for (int i = 0; i < f->statics.actuator_count; ++i)
    values[i] = f->statics.actuator_forces[i];
  return is_ok;
}

static bool compute_clearance(void *context, const km_mechanism *mechanism, km_state *state, double *values) {
  kspace_map_figures *f = context;
  int nearest;
  km_poses_compute(mechanism, state);
  bool is_ok = km_clearance_compute(f->clearance, state, f->pairs, &nearest, NULL) == KM_OK;
  values[0] = is_ok ? f->pairs[nearest].distance : nan("");
  return is_ok;
}

static const char *joined(km_arena *arena, const char *prefix, const char *name, const char *between,
                          const char *last) {
  km_text text = {0};
  km_text_format(&text, "%s%s%s%s", prefix, name, between, last);
  return km_text_move_to_arena(&text, arena);
}

static km_status create_advantage(const kt_pose *pose, kspace_map_figures *f, km_error *error) {
  km_port input, output;
  if (!km_port_default(pose->model, false, &input) || !km_port_default(pose->model, true, &output))
    return km_fail(error, KM_USAGE,
                   "--ask advantage: the model has no analysis.mechanical_advantage with input and output");
  const char **texts = KM_ARENA_NEW(&f->arena, const char *, 2);
  if (!texts)
    return km_fail(error, KM_MEMORY, "out of memory for the figures of the map");
  texts[0] = joined(&f->arena, "ma.", input.name, "/", output.name);
  texts[1] = "";
  f->figures = (km_map_figures){1, texts, texts + 1, compute_advantage, f};
  return km_transfer_create(pose->mechanism, &input, &output, &f->transfer, error);
}

static km_status create_forces(const kt_pose *pose, const int *drivers, kspace_map_figures *f, km_error *error) {
  int own = km_model_actuator_count(pose->model), count = own > 0 ? own : 2;
  int *actuators = KM_ARENA_NEW(&f->arena, int, (size_t)count);
  const char **texts = KM_ARENA_NEW(&f->arena, const char *, 2 * (size_t)count);
  if (!actuators || !texts)
    return km_fail(error, KM_MEMORY, "out of memory for the figures of the map");
  for (int i = 0; i < count; ++i)
    actuators[i] = own > 0 ? km_model_actuator(pose->model, i) : drivers[i];
  km_status status = km_forces_create_own(pose->mechanism, &f->forces, error);
  if (!status)
    status = km_statics_create(pose->mechanism, actuators, count, KM_AXES_JOINT, &f->statics, error);
  for (int i = 0; !status && i < count; ++i) {
    km_text unit = {0};
    km_push_unit(pose->model, &f->statics.actuators[i], &unit);
    texts[i] = joined(&f->arena, "f.", km_model_coordinate_label(pose->model, actuators[i]), "", "");
    texts[count + i] = km_text_move_to_arena(&unit, &f->arena);
  }
  f->figures = (km_map_figures){count, texts, texts + count, compute_forces, f};
  return status;
}

static km_status create_clearance(const kt_pose *pose, kspace_map_figures *f, km_error *error) {
  km_poses_compute(pose->mechanism, pose->state);
  km_status status = km_clearance_create(pose->mechanism, pose->state, NULL, 0, &f->clearance, error);
  const char **texts = KM_ARENA_NEW(&f->arena, const char *, 2);
  f->pairs = KM_ARENA_NEW(&f->arena, km_pair_clearance, (size_t)km_clearance_pair_count(f->clearance) + 1);
  if (status || !texts || !f->pairs)
    return status ? status : km_fail(error, KM_MEMORY, "out of memory for the figures of the map");
  texts[0] = "clearance";
  texts[1] = km_model_units(pose->model).length->suffix;
  f->figures = (km_map_figures){1, texts, texts + 1, compute_clearance, f};
  return KM_OK;
}

kt_exit kspace_map_figures_create(const kt_common *common, const kt_pose *pose, kspace_ask ask, const int *drivers,
                                  kspace_map_figures *out) {
  km_error error;
  *out = (kspace_map_figures){0};
  km_status status = KM_OK;
  if (ask == KSPACE_ASK_ADVANTAGE)
    status = create_advantage(pose, out, &error);
  else if (ask == KSPACE_ASK_FORCES)
    status = create_forces(pose, drivers, out, &error);
  else if (ask == KSPACE_ASK_CLEARANCE)
    status = create_clearance(pose, out, &error);
  if (!status && out->arena.failed)
    return KT_NO_MEMORY;
  if (status)
    kt_print_message(common, KM_ERROR, "%s", error.text);
  return kt_exit_of(status);
}

void kspace_map_figures_free(kspace_map_figures *f) {
  km_transfer_free(f->transfer);
  km_statics_free(&f->statics);
  km_forces_free(f->forces);
  km_clearance_free(f->clearance);
  km_arena_free(&f->arena);
}
