/* Notes and warnings about a motion over time. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/inspect.h"
#include "kmech/report.h"

static void report_drives(const kt_sweep_job *j, const km_history *h) {
  const km_model *model = j->pose.model;
  const char *time = km_model_units(model).time->suffix;
  for (int i = 0; i < h->exceeded_count; ++i) {
    const km_exceeded *e = &h->exceeded[i];
    const char *label = km_model_coordinate_label(model, e->coordinate);
    km_text unit = {0};
    if (e->of_force)
      km_push_unit(model, &(km_port){.kind = KM_PORT_JOINT, .coordinate = e->coordinate}, &unit);
    else
      km_text_format(&unit, "%s/%s", km_model_coordinate_unit(model, e->coordinate), time);
    kt_print_message(&j->common, KM_WARNING,
                     e->of_force
                         ? "%s: the drive of joint \"%s\" gives %.6g %s at %.6g %s, more than its max_force of %.6g"
                         : "%s: joint \"%s\" moves at %.6g %s at %.6g %s, faster than its max_rate of %.6g",
                     j->name, label, e->most, unit.data ? unit.data : "", e->time, time, e->bound);
    km_text_free(&unit);
  }
}

static void report_hinges(const kt_sweep_job *j) {
  const km_model *model = j->pose.model;
  for (int i = -1; (i = km_model_next_without_radius(model, i + 1)) >= 0;)
    kt_print_message(
        &j->common, KM_NOTE,
        "%s: joint %s has a coefficient of friction but no radius: it turns without friction, under a thrust along its "
        "axis too",
        j->name, km_model_joint_label(model, i));
}

void ksim_report_limit(const kt_common *common, const char *name, const km_model *model, const km_passed_limit *limit) {
  const char *time = km_model_units(model).time->suffix, *unit = km_model_coordinate_unit(model, limit->coordinate);
  km_text by = {0};
  if (limit->beyond > 0.0)
    km_text_format(&by, ", by up to %.6g %s", limit->beyond, unit);
  kt_print_message(
      common, KM_WARNING,
      "%s: joint \"%s\" passes its %s limit of %.6g %s at %.6g %s%s; no stop acts there: state a stop for the joint, "
      "or widen its limits",
      name, km_model_coordinate_label(model, limit->coordinate), limit->upper ? "upper" : "lower", limit->limit, unit,
      limit->time, time, by.data ? by.data : "");
  km_text_free(&by);
}

static kt_exit report_limits(const kt_sweep_job *j, const km_history *h) {
  for (int i = 0; i < h->limit_count; ++i)
    ksim_report_limit(&j->common, j->name, j->pose.model, &h->limits[i]);
  return h->limit_count > 0 ? KT_PARTIAL : KT_DONE;
}

/* True if the run ended at a crossing of --stop. */
static bool stopped(const km_history_def *run, const km_history *h) {
  return run && h->crossing_count > 0 && run->simulation.crossings[h->crossings[h->crossing_count - 1].crossing].stops;
}

kt_exit ksim_tell(kt_sweep_job *j) {
  const km_history *h = km_question_history(j->question);
  const km_history_def *run = km_question_run_def(j->question);
  const char *unit = km_model_units(j->pose.model).time->suffix;
  double end = km_table_row(h->table, km_table_rows(h->table) - 1)[0];
  kt_exit result = h->why.text[0] ? kt_exit_of(h->why.status) : KT_DONE;
  report_hinges(j);
  report_drives(j, h);
  if (run)
    result = kt_worse(result, ksim_report_rates(j, h));
  if (!kt_question_given(&j->options->asked, "ignore-limits"))
    result = kt_worse(result, report_limits(j, h));
  if (h->why.text[0] && run)
    kt_print_message(&j->common, KM_ERROR, "%s: the run ends at %.9g %s: %s", j->name, end, unit, h->why.text);
  else if (h->why.text[0])
    kt_print_message(&j->common, KM_ERROR, "%s: %s", j->name, h->why.text);
  km_text_add(&j->stopped_by, h->why.text);
  if (stopped(run, h))
    km_text_format(&j->stopped_by, "--stop at %.9g %s", end, unit);
  return result;
}
