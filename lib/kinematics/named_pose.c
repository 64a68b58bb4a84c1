/* Named poses of a model as start values: the named joints are held at their values, the others are assembled. */
#include "kmech/mechanism.h"

#include "base/arguments.h"
#include "topology/mechanism.h"

/* Stores the coupling constants of the displacements before they change. */
static void fix_coupling_constants(km_model *model) {
  for (int i = 0; i < model->coupling_count; ++i) {
    km_model_coupling *coupling = &model->couplings[i];
    if (coupling->constant_given || !coupling->ratios)
      continue;
    coupling->constant_given = true;
    coupling->constant = 0.0;
    for (int k = 0; k < coupling->count; ++k) {
      int c = coupling->coordinates[k];
      coupling->constant += coupling->ratios[k] * model->coordinates[c].position * km_model_coordinate_factor(model, c);
    }
  }
}

/* Assembles the model with `count` coordinates held and writes all coordinates to the model. False, with the model
 * unchanged, if the loops do not close or memory is out. */
static bool assemble_with_holds(km_model *model, const km_hold *holds, int count, km_status *memory_status,
                                km_error *error) {
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_error local_error;
  km_status status = km_mechanism_compile(model, holds, count, &mechanism, &local_error);
  if (!status)
    status = km_state_create(mechanism, &state, &local_error);
  if (!status)
    status = km_assemble(mechanism, state, NULL, &local_error);
  for (int c = 0; c < model->coordinate_count && !status; ++c)
    model->coordinates[c].position = km_state_coordinate(state, c);
  km_state_free(state);
  km_mechanism_free(mechanism);
  if (status == KM_MEMORY)
    *memory_status = km_fail(error, KM_MEMORY, "out of memory for a pose");
  return status == KM_OK;
}

/* Holds the named joints at their values and assembles; halves their number until the loops close. */
km_status km_model_apply_pose(km_model *model, int index, km_error *error) {
  km_status status = km_check_given(model != NULL, "model", error);
  if (!status)
    status = km_check_index(index, model->pose_count, "pose", error);
  if (!status)
    status = km_model_keep_unedited(model, error);
  if (status)
    return status;
  const km_model_pose *pose = &model->poses[index];
  km_hold *holds = KM_NEW(km_hold, (size_t)pose->count);
  if (!holds)
    return km_fail(error, KM_MEMORY, "out of memory for a pose");
  fix_coupling_constants(model);
  for (int k = 0; k < pose->count; ++k) {
    holds[k] = (km_hold){pose->coordinates[k], pose->values[k]};
    model->coordinates[pose->coordinates[k]].position = pose->values[k];
  }
  for (int count = pose->count; count > 0 && !status && !assemble_with_holds(model, holds, count, &status, error);)
    count /= 2;
  km_free(holds);
  return status;
}
