/* kmob check: everything suspicious about a model. */
#include "kmob/kmob.h"

#include "kmech/data.h"
#include "kmech/report.h"

static kt_exit write_findings(const kmob_request *o, const kt_pose *pose, const km_findings *findings) {
  km_text out = {0};
  km_arena arena = {0};
  if (o->pose.json) {
    km_value *record = km_record_head(pose->mechanism, "kmob", o->pose.model, &arena);
    if (!arena.failed)
      km_findings_record(findings, record, &arena);
    if (!arena.failed)
      km_json_write(record, &out);
    out.failed = out.failed || arena.failed;
  } else {
    km_findings_print(findings, o->pose.model, &out);
  }
  kt_exit result = kt_answer(&o->pose, "check", &out);
  km_arena_free(&arena);
  km_text_free(&out);
  return result;
}

/* True if the options request another configuration than the file's. */
static bool is_moved(const kmob_request *o) {
  return o->pose.sets.count > 0 || o->pose.common.mode > 0 || o->pose.common.pose;
}

static kt_exit check(const kmob_request *o, const kt_pose *pose, const km_messages *messages) {
  km_findings findings;
  km_error error;
  kt_progress progress = kt_progress_start(&o->pose.common);
  km_status status = km_check(pose->mechanism, pose->state, messages, kt_progress_show, &progress, &findings, &error);
  kt_progress_end(&progress);
  if (!status && is_moved(o))
    km_findings_leave_out(&findings, "start");
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&o->pose.common, KM_ERROR, "%s: %s", o->pose.model, error.text);
  else
    result = write_findings(o, pose, &findings);
  size_t counted = findings.counts[KM_FINDING_FAULT] + findings.counts[KM_FINDING_WARNING];
  if (result == KT_DONE && (o->strict ? findings.count : counted) > 0)
    result = KT_PARTIAL;
  km_findings_free(&findings);
  return result;
}

kt_exit kmob_check(int argc, char **argv) {
  kmob_request o =
      kmob_read_request(argc, argv,
                        "Everything suspicious about a model, each with what to do. Exit status 1 if there "
                        "is a fault or a warning.",
                        KMOB_CHECKS);
  kt_pose pose;
  km_messages *messages = km_messages_create();
  o.pose.common.found = messages;
  kt_exit result = kt_request_open(&o.pose, &pose);
  if (result == KT_DONE)
    result = check(&o, &pose, messages);
  kt_close(&pose);
  km_messages_free(messages);
  return result;
}
