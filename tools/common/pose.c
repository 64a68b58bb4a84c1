/* Brings a model to the configuration requested by a command. */
#include "common/pose.h"

#include "common/assembly_mode.h"
#include "kmech/base.h"
#include "kmech/continuation.h"
#include "kmech/inspect.h"
#include "kmech/mobility.h"
#include "kmech/model.h"

/* The model's own holds, overridden by the command line's. */
static kt_exit gather_holds(const kt_common *common, const km_model *model, const kt_texts *texts, kt_settings *out) {
  int count = km_model_hold_count(model);
  if (count > 0) {
    out->items = KM_NEW(kt_setting, (size_t)count);
    if (!out->items)
      return KT_NO_MEMORY;
    for (int h = 0; h < count; ++h) {
      km_hold hold = km_model_hold_at(model, h);
      out->items[out->count++] = (kt_setting){hold.coordinate, hold.value};
    }
  }
  return kt_settings_add(common, model, "--hold", (char **)(size_t)texts->items, texts->count, out);
}

static km_hold *as_holds(const kt_settings *settings) {
  km_hold *holds = KM_NEW(km_hold, (size_t)settings->count);
  for (int i = 0; holds && i < settings->count; ++i)
    holds[i] = (km_hold){settings->items[i].coordinate, settings->items[i].value};
  return holds;
}

static kt_exit check_conflicts(const kt_common *common, const km_model *model, const kt_settings *holds,
                               const kt_settings *sets) {
  for (int i = 0; i < sets->count; ++i)
    for (int k = 0; k < holds->count; ++k)
      if (sets->items[i].coordinate == holds->items[k].coordinate) {
        kt_print_message(common, KM_ERROR, "--set: \"%s\" is held; expected a joint that is free to move",
                         km_model_coordinate_label(model, sets->items[i].coordinate));
        return KT_USAGE;
      }
  return KT_DONE;
}

static kt_exit reach(const kt_common *common, const char *path, const kt_settings *holds, const kt_settings *sets,
                     kt_pose *out) {
  km_error error;
  km_hold *held = as_holds(holds), *set = as_holds(sets);
  km_status status = held && set ? km_mechanism_compile_at(out->model, held, holds->count, set, sets->count,
                                                           &out->mechanism, &out->state, &error)
                                 : km_fail(&error, KM_MEMORY, "out of memory");
  km_free(held);
  km_free(set);
  if (status)
    kt_print_message(common, KM_ERROR, "%s: %s", path, error.text);
  else
    kt_detail(common, "%s: at its pose; held coordinates: %d, moved by --set: %d, characteristic length %g %s", path,
              holds->count, sets->count, km_mechanism_characteristic_length(out->mechanism, NULL),
              km_model_units(out->model).length->suffix);
  return kt_exit_of(status);
}

/* The requested named pose. */
static kt_exit copy_pose(const kt_common *common, const char *path, km_model *model) {
  int pose;
  km_error error;
  km_status status = km_model_find_pose(model, common->pose, &pose, &error);
  if (status)
    kt_print_message(common, KM_ERROR, "--pose: %s", error.text);
  else if ((status = km_model_apply_pose(model, pose, &error)))
    kt_print_message(common, KM_ERROR, "%s: %s", path, error.text);
  return kt_exit_of(status);
}

/* Notes about the geometry, unless the command gathers its findings itself. */
static kt_exit report_geometry(const kt_common *common, const char *path, const kt_pose *pose) {
  km_messages *notes = common->found ? NULL : km_messages_create();
  if (!notes)
    return common->found ? KT_DONE : KT_NO_MEMORY;
  km_geometry_notes(pose->mechanism, pose->state, notes);
  kt_report_messages(common, path, notes, KM_OK, NULL);
  km_messages_free(notes);
  return KT_DONE;
}

kt_exit kt_move_to_request(const kt_common *common, const char *path, const kt_texts *holds, const kt_texts *sets,
                           kt_pose *out) {
  kt_settings held = {0}, set = {0};
  kt_exit result = common->pose ? copy_pose(common, path, out->model) : KT_DONE;
  if (result == KT_DONE)
    result = gather_holds(common, out->model, holds, &held);
  if (result == KT_DONE)
    result = kt_settings_add(common, out->model, "--set", (char **)(size_t)sets->items, sets->count, &set);
  if (result == KT_DONE)
    result = check_conflicts(common, out->model, &held, &set);
  if (result == KT_DONE)
    result = reach(common, path, &held, &set, out);
  if (result == KT_DONE)
    result = report_geometry(common, path, out);
  if (result == KT_DONE && common->mode > 0)
    result = kt_mode_take(common, path, sets, out);
  kt_settings_free(&held);
  kt_settings_free(&set);
  return result;
}

kt_exit kt_open_varied(const kt_common *common, const char *path, const km_assignment *values, int count,
                       const kt_texts *holds, const kt_texts *sets, kt_pose *out) {
  kt_exit result;
  *out = (kt_pose){0};
  out->model = kt_load_varied(common, path, values, count, &result);
  return out->model ? kt_move_to_request(common, path, holds, sets, out) : result;
}

kt_exit kt_open(const kt_common *common, const char *path, const kt_texts *holds, const kt_texts *sets, kt_pose *out) {
  return kt_open_varied(common, path, NULL, 0, holds, sets, out);
}

void kt_close(kt_pose *pose) {
  km_state_free(pose->state);
  km_mechanism_free(pose->mechanism);
  km_model_free(pose->model);
}
