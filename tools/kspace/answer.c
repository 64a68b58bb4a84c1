/* Clearance to keep, and the forms of an answer: code that the commands share. */
#include "kspace/kspace.h"

#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/model.h"

#include <math.h>
#include <string.h>

kt_exit kspace_write_csv(const kt_common *common, const char *base, const km_table *table, const char *result) {
  size_t size = km_table_csv(table, NULL, 0);
  char *bytes = size > 0 ? KM_NEW(char, size + 1) : NULL;
  km_text out = {0};
  kt_exit written = KT_NO_MEMORY;
  if (bytes && km_table_csv(table, bytes, size + 1) == size) {
    km_text_add(&out, bytes);
    written = out.failed ? KT_NO_MEMORY : kt_write(common, base, result, "csv", &out);
  }
  km_free(bytes);
  km_text_free(&out);
  return written;
}

kt_exit kspace_read_clearance(const kt_common *common, const char *text, const char *model, const kt_pose *pose,
                              km_clearance **out, double *least) {
  km_error error;
  *out = NULL;
  if (!text)
    return KT_DONE;
  if (!kt_number(text, least))
    return kt_usage(common, "--clearance", text, "a length in the model's unit");
  km_poses_compute(pose->mechanism, pose->state);
  km_status status = km_clearance_create(pose->mechanism, pose->state, NULL, 0, out, &error);
  if (status)
    kt_print_message(common, KM_ERROR, "%s: %s", model, error.text);
  return status ? kt_exit_of(status) : KT_DONE;
}

/* True if limits of a coordinate could count: it has some, and moves without being a driver. */
static bool has_idle_limits(const kt_pose *pose, int c, const int *drivers, int count) {
  double low = -HUGE_VAL, high = HUGE_VAL;
  km_model_coordinate_limits(pose->model, c, &low, &high);
  for (int d = 0; d < count; ++d)
    if (c == drivers[d])
      return false;
  return (isfinite(low) || isfinite(high)) && !km_coordinate_is_held(pose->mechanism, c);
}

void kspace_print_limits(const kt_pose *pose, const int *drivers, int count, km_text *out) {
  int limited = 0, counted = -1;
  for (int c = 0; c < km_model_coordinate_count(pose->model); ++c) {
    int joint = km_model_coordinate_joint(pose->model, c);
    if (joint == counted || !has_idle_limits(pose, c, drivers, count))
      continue;
    counted = joint;
    ++limited;
  }
  if (limited > 0)
    km_text_format(out, "joint limits don't count: %d%s joint%s; --limits keeps them\n", limited,
                   count > 0 ? " other" : "", limited == 1 ? " has some" : "s have some");
}

void kspace_record_completeness(km_mode_gap gap, km_value *record, km_arena *arena) {
  km_value_boolean(arena, record, "complete", gap == KM_GAP_NONE);
  if (gap != KM_GAP_NONE)
    km_value_string(arena, record, "reason", km_mode_gap_name(gap));
}

bool kspace_read_formats(const kt_common *common, const char *format, const char *among, const char *model,
                         kspace_files *files) {
  const char *usual = strstr(among, "svg") ? "csv,svg" : "csv";
  if (!kt_formats_parse_among(common, format ? format : usual, among, &files->formats))
    return false;
  int printed = files->formats.wanted[KT_JSON] ? 1 : 0;
  if (format && !files->base && kt_formats_count(&files->formats) > printed) {
    kt_base_name(model, files->name, sizeof files->name);
    files->base = files->name;
  }
  return true;
}

kt_exit kspace_deliver(const kt_common *common, const kspace_files *files, const kspace_answer *a) {
  const char *base = files->base;
  const kt_formats *formats = &files->formats;
  km_arena arena = {0};
  km_text text = {0}, record = {0};
  bool wants_record = formats->wanted[KT_JSON];
  if (wants_record)
    km_json_write(a->record(a->context, &arena), &record);
  a->print(a->context, &text);
  kt_exit result = arena.failed || record.failed || text.failed ? KT_NO_MEMORY : KT_DONE;
  for (int format = 0; result == KT_DONE && base && format < KT_FORMATS; ++format)
    if (formats->wanted[format])
      result = a->write(a->context, (kt_format)format, &record);
  if (result == KT_DONE)
    result = kt_print(common, wants_record && !base ? &record : &text);
  km_text_free(&text);
  km_text_free(&record);
  km_arena_free(&arena);
  return result;
}
