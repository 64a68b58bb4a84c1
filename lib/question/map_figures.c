/* Figures that are added to each cell of a map (docs/theory.md 4.19): at the cell's configuration
 *
 *   advantage : f_out / f_in of the model's input and output (8)
 *   forces    : the actuators' forces under the model's loads (9)
 *   clearance : least distance of all pairs of bodies (14.10) */
#include "base/arguments.h"
#include "kinematics/state.h"
#include "kmech/clearance.h"
#include "kmech/dynamics.h"
#include "kmech/inspect.h"
#include "kmech/space.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"
#include "topology/mechanism.h"

#include <math.h>

/* The figures, and what they are computed with. */
typedef struct quantity_figures {
  km_map_figures figures; /* first member: the caller's pointer */
  km_arena arena;
  km_transfer *transfer;
  km_statics statics;
  km_forces *forces;
  km_clearance *clearance;
  km_pair_clearance *pairs; /* [pair] of the present cell */
} quantity_figures;

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the figures of the map");
}

static bool compute_advantage(void *context, const km_mechanism *mechanism, km_state *state, double *values) {
  quantity_figures *f = context;
  km_advantage advantage;
  bool is_ok = km_transfer_compute(mechanism, state, f->transfer, &advantage) == KM_OK;
  values[0] = advantage.value;
  return is_ok;
}

static bool compute_forces(void *context, const km_mechanism *mechanism, km_state *state, double *values) {
  quantity_figures *f = context;
  bool is_ok = km_statics_compute(mechanism, state, f->forces, &f->statics) != KM_MEMORY;
  for (int i = 0; i < f->statics.actuator_count; ++i)
    values[i] = f->statics.actuator_forces[i];
  return is_ok;
}

static bool compute_clearance(void *context, const km_mechanism *mechanism, km_state *state, double *values) {
  quantity_figures *f = context;
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

static km_status create_advantage(const km_mechanism *m, quantity_figures *f, km_error *error) {
  km_port input, output;
  if (!km_port_default(m->model, false, &input) || !km_port_default(m->model, true, &output))
    return km_fail(error, KM_USAGE,
                   "leverage on a map: the model has no analysis.mechanical_advantage with input and output");
  const char **texts = KM_ARENA_NEW(&f->arena, const char *, 2);
  if (!texts)
    return no_memory(error);
  texts[0] = joined(&f->arena, "ma.", input.name, "/", output.name);
  texts[1] = "";
  f->figures = (km_map_figures){1, texts, texts + 1, compute_advantage, f};
  return km_transfer_create(m, &input, &output, &f->transfer, error);
}

static km_status create_forces(const km_mechanism *m, const int *drivers, quantity_figures *f, km_error *error) {
  int own = km_model_actuator_count(m->model), count = own > 0 ? own : 2;
  int *actuators = KM_ARENA_NEW(&f->arena, int, (size_t)count);
  const char **texts = KM_ARENA_NEW(&f->arena, const char *, 2 * (size_t)count);
  if (!actuators || !texts)
    return no_memory(error);
  for (int i = 0; i < count; ++i)
    actuators[i] = own > 0 ? km_model_actuator(m->model, i) : drivers[i];
  km_status status = km_forces_create_own(m, &f->forces, error);
  if (!status)
    status = km_statics_create(m, actuators, count, KM_AXES_JOINT, &f->statics, error);
  for (int i = 0; !status && i < count; ++i) {
    km_text unit = {0};
    km_push_unit(m->model, &f->statics.actuators[i], &unit);
    texts[i] = joined(&f->arena, "f.", km_model_coordinate_label(m->model, actuators[i]), "", "");
    texts[count + i] = km_text_move_to_arena(&unit, &f->arena);
  }
  f->figures = (km_map_figures){count, texts, texts + count, compute_forces, f};
  return status;
}

static km_status create_clearance(const km_mechanism *m, km_state *state, quantity_figures *f, km_error *error) {
  km_poses_compute(m, state);
  km_status status = km_clearance_create(m, state, NULL, 0, &f->clearance, error);
  const char **texts = KM_ARENA_NEW(&f->arena, const char *, 2);
  f->pairs = KM_ARENA_NEW(&f->arena, km_pair_clearance, (size_t)km_clearance_pair_count(f->clearance) + 1);
  if (status || !texts || !f->pairs)
    return status ? status : no_memory(error);
  texts[0] = "clearance";
  texts[1] = km_model_units(m->model).length->suffix;
  f->figures = (km_map_figures){1, texts, texts + 1, compute_clearance, f};
  return KM_OK;
}

static km_status check_drivers(const km_mechanism *m, const int *drivers, km_error *error) {
  km_status status = km_check_given(drivers != NULL, "drivers", error);
  for (int d = 0; d < 2 && !status; ++d)
    status = km_check_index(drivers[d], m->coordinate_count, "coordinate", error);
  return status;
}

km_status km_map_figures_create(const km_mechanism *m, km_state *state, km_map_quantity quantity, const int *drivers,
                                km_map_figures **out, km_error *error) {
  km_status status = km_check_given(out != NULL, "out", error);
  if (status)
    return status;
  *out = NULL;
  status = km_check_state(m, state, error);
  if (!status)
    status = check_drivers(m, drivers, error);
  if (status || quantity == KM_MAP_QUANTITY_MOBILITY)
    return status;
  quantity_figures *f = KM_NEW(quantity_figures, 1);
  if (!f)
    return no_memory(error);
  status = quantity == KM_MAP_QUANTITY_ADVANTAGE ? create_advantage(m, f, error)
           : quantity == KM_MAP_QUANTITY_FORCES  ? create_forces(m, drivers, f, error)
           : quantity == KM_MAP_QUANTITY_CLEARANCE
               ? create_clearance(m, state, f, error)
               : km_fail(error, KM_USAGE, "`quantity`: expected %s", KM_MAP_QUANTITY_WORDS);
  if (!status && f->arena.failed)
    status = no_memory(error);
  if (status)
    km_map_figures_free(&f->figures);
  else
    *out = &f->figures;
  return status;
}

void km_map_figures_free(km_map_figures *figures) {
  quantity_figures *f = (quantity_figures *)figures;
  if (!f)
    return;
  km_transfer_free(f->transfer);
  km_statics_free(&f->statics);
  km_forces_free(f->forces);
  km_clearance_free(f->clearance);
  km_arena_free(&f->arena);
  km_free(f);
}
