/* ksim run --from: continues from the last row of the table of an earlier run. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/report.h"

static kt_exit read_table(const ksim_options *o, km_table **out) {
  km_text text = {0};
  km_error error;
  km_status status = km_file_read(o->from, &text, &error);
  if (!status)
    status = km_csv_read(&text, o->from, out, &error);
  km_text_free(&text);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "--from: %s", error.text);
  return kt_exit_of(status);
}

kt_exit ksim_continue(ksim_work *w) {
  const ksim_options *o = w->options;
  km_table *table = NULL;
  km_error error;
  if (!o->from)
    return KT_DONE;
  if (o->sets.count > 0)
    return kt_usage(&o->common, "--from", "a table beside --set", "one of them: both give the pose");
  kt_exit result = read_table(o, &table);
  if (result != KT_DONE)
    return result;
  km_status status =
      km_history_resume(w->pose.mechanism, table, o->from, w->pose.state, &w->def.start, &w->memory, &error);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "--from %s", error.text);
  w->def.simulation.memory = w->memory;
  km_table_free(table);
  return kt_exit_of(status);
}
