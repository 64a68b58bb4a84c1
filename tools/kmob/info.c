/* kmob info, kmob at: one pose. */
#include "kmob/kmob.h"

#include "kmech/data.h"
#include "kmech/report.h"

static void print_modes(const km_model *model, const km_modes *modes, int driver, km_text *out) {
  km_text_format(out, "\n%s assembly mode%s", modes->count == 1 ? "one" : "different", modes->count == 1 ? "" : "s");
  if (driver >= 0)
    km_text_format(out, " with %s where it is", km_model_coordinate_label(model, driver));
  km_text_format(out, "%s; found from %d starting configuration%s",
                 modes->isolated ? "" : " (in some of them something still moves: those are samples)", modes->closed,
                 modes->closed == 1 ? "" : "s");
  if (modes->isolated && modes->once > 0)
    km_text_format(out, ", %d of them by one alone, so that there may be more", modes->once);
  km_text_add(out, "\n");
  if (modes->isolated && modes->outside)
    km_text_format(out, "%d further mode%s outside the joint limits\n", modes->outside,
                   modes->outside == 1 ? " lies" : "s lie");
  for (int i = 0; i < modes->count; ++i) {
    km_text_format(out, "  %d:", i + 1);
    for (int c = 0; c < km_model_coordinate_count(model); ++c)
      km_text_format(out, "%s %s %.6g %s", c ? "," : "", km_model_coordinate_label(model, c),
                     modes->coordinates[i * km_model_coordinate_count(model) + c], km_model_coordinate_unit(model, c));
    km_text_add(out, "\n");
  }
}

static void add_modes(const km_model *model, const km_modes *modes, int driver, km_value *record, km_arena *arena) {
  if (driver >= 0)
    km_value_string(arena, record, "modes_driver", km_model_coordinate_label(model, driver));
  km_value_boolean(arena, record, "modes_isolated", modes->isolated);
  km_value_number(arena, record, "modes_closed_starts", modes->closed);
  km_value_number(arena, record, "modes_found_once", modes->once);
  km_value_number(arena, record, "modes_outside_limits", modes->outside);
  km_value *list = km_value_add(arena, record, "modes", KM_LIST);
  for (int i = 0; i < modes->count && !arena->failed; ++i) {
    km_value *mode = km_value_add(arena, list, NULL, KM_OBJECT);
    for (int c = 0; c < km_model_coordinate_count(model); ++c)
      km_value_number(arena, mode, km_model_coordinate_label(model, c),
                      modes->coordinates[i * km_model_coordinate_count(model) + c]);
  }
}

/* Warnings about ranks that the data don't decide. */
static km_status report_doubts(const kmob_request *o, const kt_pose *pose, km_error *error) {
  km_messages *doubts = km_messages_create();
  km_status status = doubts ? km_rank_doubts(pose->mechanism, pose->state, doubts, error)
                            : km_fail(error, KM_MEMORY, "out of memory for the ranks");
  kt_report_messages(&o->pose.common, o->pose.model, doubts, KM_OK, NULL);
  km_messages_free(doubts);
  return status;
}

/* The diagnosis, with a progress bar. */
static km_status diagnose(const kmob_request *o, const kt_pose *pose, km_diagnosis *out, km_error *error) {
  kt_progress progress = kt_progress_start(&o->pose.common);
  km_status status = km_diagnosis_find(pose->mechanism, pose->state, kt_progress_show, &progress, out, error);
  kt_progress_end(&progress);
  return status;
}

static kt_exit describe(const kmob_request *o, const kt_pose *pose, km_text *out) {
  km_mobility mobility;
  km_diagnosis diagnosis;
  km_error error;
  km_arena arena = {0};
  km_modes modes = {0};
  int driver = -1;
  km_status status = diagnose(o, pose, &diagnosis, &error);
  if (!status && o->modes)
    status = kt_modes_find(&o->pose.common, &o->pose.sets, pose, &driver, &modes, &error);
  if (!status && km_mobility_compute(pose->mechanism, pose->state, &mobility))
    status = km_fail(&error, KM_MEMORY, "out of memory for the mobility");
  if (!status)
    status = report_doubts(o, pose, &error);
  if (status) {
    kt_print_message(&o->pose.common, KM_ERROR, "%s: %s", o->pose.model, error.text);
  } else if (o->pose.json) {
    km_value *record = km_mobility_record(pose->mechanism, pose->state, &mobility, o->pose.model, &arena);
    if (record)
      km_diagnosis_record(pose->mechanism, &diagnosis, record, &arena);
    if (!arena.failed && o->modes)
      add_modes(pose->model, &modes, driver, record, &arena);
    if (!arena.failed)
      km_json_write(record, out);
  } else {
    km_mobility_print(pose->mechanism, pose->state, &mobility, &diagnosis.finite, o->pose.model, o->pose.common.verbose,
                      out);
    km_diagnosis_print(pose->mechanism, &diagnosis, o->pose.common.verbose, out);
    if (o->modes)
      print_modes(pose->model, &modes, driver, out);
  }
  bool arena_failed = arena.failed;
  km_arena_free(&arena);
  km_diagnosis_free(&diagnosis);
  km_modes_free(&modes);
  return arena_failed ? KT_NO_MEMORY : kt_exit_of(status);
}

static kt_exit run(const kmob_request *o) {
  kt_pose pose;
  km_text out = {0};
  kt_exit result = kt_request_open(&o->pose, &pose);
  if (result == KT_DONE)
    result = describe(o, &pose, &out);
  if (result == KT_DONE)
    result = kt_answer(&o->pose, "mobility", &out);
  km_text_free(&out);
  kt_close(&pose);
  return result;
}

kt_exit kmob_info(int argc, char **argv) {
  kmob_request o = kmob_read_request(
      argc, argv, "Topology, substructures, mobility and mobility numbers at the file's pose.", KMOB_INFO);
  return run(&o);
}

kt_exit kmob_at(int argc, char **argv) {
  kmob_request o = kmob_read_request(
      argc, argv, "Mobility and mobility numbers at a pose, reached from the file's pose along its branch.", KMOB_AT);
  return run(&o);
}
