/* kstatic sweep and kstatic report: the balance of forces over a driver's range. */
#include "common/report.h"
#include "kstatic/kstatic.h"

#include "report/document/statics_report.h"
#include "report/plot/statics_plot.h"
#include "report/record/statics_record.h"

typedef struct options {
  kt_sweep_options sweep;
  kstatic_options acting;
} options;

/* What is made of one model. */
typedef struct product {
  kstatic_balance balance;
  km_statics_sweep sweep;
} product;

static kt_exit prepare(kt_sweep_job *j) {
  product *p = j->own = KM_NEW(product, 1);
  return p ? kstatic_prepare(&j->common, j->path, &j->pose, &((const options *)j->options->own)->acting, &p->balance)
           : KT_INTERNAL;
}

static km_status run(kt_sweep_job *j, const km_sweep **motion, km_error *error) {
  product *p = j->own;
  *motion = &p->sweep.motion;
  km_status status = km_statics_sweep_run(j->pose.mechanism, j->pose.state, &j->plan, p->balance.forces,
                                          &p->balance.statics, &p->sweep, error);
  if (status == KM_PARTIAL && p->sweep.unheld)
    kt_say(&j->common, KM_ERROR, "%s: the actuators can't hold %zu of %zu rows, first at %.9g (kstatic at tells why)",
           j->path, p->sweep.unheld, km_table_rows(p->sweep.motion.table), p->sweep.first_unheld);
  return status;
}

static void print(const kt_sweep_job *j, km_text *out) {
  km_statics_sweep_print(j->pose.mechanism, &j->plan, &((const product *)j->own)->sweep, j->path, out);
}

static const km_table *rows(const kt_sweep_job *j) {
  return ((const product *)j->own)->sweep.motion.table;
}

static km_value *record(const kt_sweep_job *j, km_arena *arena) {
  return km_statics_sweep_record(j->pose.mechanism, &((const product *)j->own)->sweep,
                                 j->stopped_by.data ? j->stopped_by.data : "", j->path, arena);
}

static km_status plot(const kt_sweep_job *const *jobs, int count, km_canvas_format format, km_text *out,
                      km_error *error) {
  km_plotted_statics plotted[KT_MOST_MODELS];
  for (int i = 0; i < count; ++i) {
    const km_statics_sweep *sweep = &((const product *)jobs[i]->own)->sweep;
    plotted[i] = (km_plotted_statics){{jobs[i]->pose.mechanism, &jobs[i]->plan, &sweep->motion, jobs[i]->base}, sweep};
  }
  return km_statics_plot(plotted, count, format, out, error);
}

static void free_own(kt_sweep_job *j) {
  product *p = j->own;
  if (p) {
    km_statics_sweep_free(&p->sweep);
    kstatic_free(&p->balance);
  }
  km_free(p);
}

kt_exit kstatic_sweep(int argc, char **argv) {
  static const kt_sweeping sweeping = {"forces", prepare, run, print, rows, record, plot, free_own};
  options o = {.sweep = {.common = KT_COMMON("kstatic")}};
  kt_options all = {0};
  const kt_option point[] = {KT_PATH_POINT(&o.sweep.points)};
  kt_sweep_options_several(&all, &o.sweep, KT_SWEEP_BASE("forces"));
  kstatic_options_add(&all, &o.acting);
  KT_OPTIONS_ADD(&all, point);
  kt_options_read(
      &all,
      "What actuators must hold, and what every joint carries, over the range of a driver; where a load balances "
      "itself, and where forces peak. Exit status 1 if a part of the range can't be held."
      "\vColumns beside those of every sweep: f.JOINT of the actuators (nan where they can't hold), fbar.JOINT "
      "least-norm forces, r.JOINT.fx … tz reactions of parent on child, held (1 or 0). JSON adds events [{actuator, "
      "event (zero, peak, unbounded), s, force}], degree_of_indeterminacy, rows_not_held, held_joints.",
      argc, argv);
  o.sweep.own = &o;
  return kt_sweep(&o.sweep, &sweeping);
}

static km_status write_report(const kt_sweep_job *j, bool html, km_text *out, km_error *error) {
  const product *p = j->own;
  km_plotted_statics plotted = {{j->pose.mechanism, &j->plan, &p->sweep.motion, j->base}, &p->sweep};
  km_text acting = {0};
  kstatic_words(j->pose.model, &((const options *)j->options->own)->acting, &acting);
  km_status status = km_statics_report(&plotted, &p->balance.statics, acting.data ? acting.data : "",
                                       j->stopped_by.data ? j->stopped_by.data : "", html, out, error);
  km_text_free(&acting);
  return status;
}

kt_exit kstatic_report(int argc, char **argv) {
  static const kt_reporting reporting = {"forces-report", prepare, run, write_report, free_own};
  options o = {.sweep = {.common = KT_COMMON("kstatic")}};
  kt_options all = {0};
  kt_report_options(&all, &o.sweep, KT_REPORT_BASE("forces-report"));
  kstatic_options_add(&all, &o.acting);
  kt_options_read(&all,
                  "A report to hand on: the mechanism in its poses, what every actuator must hold, where it rests or "
                  "peaks, and the reactions at the worst pose, as PDF pages or one HTML file.",
                  argc, argv);
  o.sweep.own = &o;
  return kt_report(&o.sweep, &reporting);
}
