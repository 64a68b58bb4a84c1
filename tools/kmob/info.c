/* kmob info, kmob at: one pose. */
#include "kmob/kmob.h"

#include "base/json.h"
#include "report/diagnosis_record.h"
#include "report/mobility_record.h"

static kt_exit describe(const kmob_request *o, const kmob_pose *pose, km_text *out) {
  km_mobility mobility;
  km_diagnosis diagnosis;
  km_error error;
  km_arena arena = {0};
  km_status status = km_diagnosis_find(pose->mechanism, pose->state, &diagnosis, &error);
  km_mobility_update(pose->mechanism, pose->state, &mobility);
  if (status) {
    kt_say(&o->common, KM_ERROR, "%s: %s", o->model, error.text);
  } else if (o->json) {
    km_value *record = km_mobility_record(pose->mechanism, pose->state, &mobility, o->model, &arena);
    if (record)
      km_diagnosis_record(pose->mechanism, &diagnosis, record, &arena);
    if (!arena.failed)
      km_json_write(record, out);
    status = arena.failed ? KM_MEMORY : KM_OK;
  } else {
    km_mobility_print(pose->mechanism, pose->state, &mobility, o->model, out);
    km_diagnosis_print(pose->mechanism, &diagnosis, out);
  }
  km_arena_free(&arena);
  km_diagnosis_free(&diagnosis);
  return kt_exit_of(status);
}

static kt_exit run(const kmob_request *o) {
  kmob_pose pose;
  km_text out = {0};
  kt_exit result = kmob_open(&o->common, o->model, &o->holds, &o->sets, &pose);
  if (result == KT_DONE)
    result = describe(o, &pose, &out);
  if (result == KT_DONE)
    result = kmob_answer(o, "mobility", &out);
  km_text_free(&out);
  kmob_close(&pose);
  return result;
}

kt_exit kmob_info(int argc, char **argv) {
  kmob_request o = kmob_read_request(
      argc, argv, "Topology, substructures, mobility and mobility numbers at the file's pose.", false);
  return run(&o);
}

kt_exit kmob_at(int argc, char **argv) {
  kmob_request o = kmob_read_request(
      argc, argv, "Mobility and mobility numbers at a pose, reached from the file's pose along its branch.", true);
  return run(&o);
}
