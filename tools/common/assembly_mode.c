/* Assembly modes on the command line: how they are numbered, and bringing a pose to one. */
#include "common/assembly_mode.h"

#include "kmech/base.h"
#include "kmech/inspect.h"

enum { STARTS = 300 };

/* The driver, -1 for a structure. */
static km_status find_driver(const kt_texts *sets, const km_model *model, int *driver, km_error *error) {
  *driver = km_model_sweep_coordinate(model);
  if (sets->count > 0) {
    const char *rest = sets->items[0];
    kt_piece label = kt_split(&rest, "=");
    km_status status = km_model_find_coordinate(model, label.text, driver, error);
    km_free(label.text);
    return status;
  }
  return KM_OK;
}

km_status kt_modes_find(const kt_common *common, const kt_texts *sets, const kt_pose *pose, int *driver,
                        km_modes *modes, km_error *error) {
  *modes = (km_modes){0};
  km_status status = find_driver(sets, pose->model, driver, error);
  return status ? status
                : km_modes_find(pose->mechanism, pose->state, *driver, STARTS, common->seed, NULL, NULL, modes, error);
}

/* Closes the loops at the mode's coordinates, which do so already but for rounding. */
static km_status take(const kt_pose *pose, const double *coordinates, km_error *error) {
  km_assembly evidence;
  km_status status = km_state_set_coordinates(pose->mechanism, pose->state, coordinates, error);
  return status ? status : km_assemble(pose->mechanism, pose->state, &evidence, error);
}

kt_exit kt_mode_take(const kt_common *common, const char *path, const kt_texts *sets, const kt_pose *pose) {
  km_modes modes;
  km_error error;
  int driver = -1;
  km_status status = kt_modes_find(common, sets, pose, &driver, &modes, &error);
  if (!status && common->mode > modes.count)
    status = km_fail(&error, KM_USAGE, "--mode %d: %s%s%s there %s %d; expected %s%d", common->mode,
                     driver < 0 ? "" : "with ", driver < 0 ? "" : km_model_coordinate_label(pose->model, driver),
                     driver < 0 ? "" : " where it is", modes.count == 1 ? "is only" : "are only", modes.count,
                     modes.count == 1 ? "" : "1 to ", modes.count);
  if (!status)
    status = take(pose, modes.coordinates + (common->mode - 1) * km_model_coordinate_count(pose->model), &error);
  km_modes_free(&modes);
  if (status)
    kt_print_message(common, KM_ERROR, "%s: %s", path, error.text);
  return kt_exit_of(status);
}
