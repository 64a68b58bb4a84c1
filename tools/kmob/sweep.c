/* kmob sweep: mobility numbers over a driver's range. */
#include "common/sweep.h"
#include "kmob/kmob.h"

#include "report/plot/mobility_plot.h"
#include "report/record/mobility_record.h"

typedef struct options {
  kt_sweep_options sweep;
  bool singularities;
} options;

/* What is known of one model's sweep. */
typedef struct findings {
  km_mobility_sweep sweep;
  km_sweep_redundancies redundancies;
} findings;

static km_status run(kt_sweep_job *j, const km_sweep **motion, km_error *error) {
  const options *o = j->options->own;
  findings *f = j->own = KM_NEW(findings, 1);
  if (!f)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  j->plan.singularities = o->singularities;
  *motion = &f->sweep.motion;
  km_status status = km_mobility_sweep_run(j->pose.mechanism, j->pose.state, &j->plan, &f->sweep, error);
  if (status != KM_OK && status != KM_PARTIAL)
    return status;
  km_status found =
      km_sweep_redundancies_find(j->pose.mechanism, *motion, o->sweep.formats.wanted[KT_JSON], &f->redundancies, error);
  return found ? found : status;
}

static void print(const kt_sweep_job *j, km_text *out) {
  const findings *f = j->own;
  km_mobility_sweep_print(j->pose.mechanism, &j->plan, &f->sweep, &f->redundancies, j->path, out);
}

static const km_table *rows(const kt_sweep_job *j) {
  return ((const findings *)j->own)->sweep.motion.table;
}

static km_value *record(const kt_sweep_job *j, km_arena *arena) {
  const findings *f = j->own;
  return km_mobility_sweep_record(j->pose.mechanism, &f->sweep, &f->redundancies,
                                  j->stopped_by.data ? j->stopped_by.data : "", j->path, arena);
}

static km_status plot(const kt_sweep_job *const *jobs, int count, km_canvas_format format, km_text *out,
                      km_error *error) {
  km_plotted_sweep plotted[KT_MOST_MODELS];
  for (int i = 0; i < count; ++i)
    plotted[i] = (km_plotted_sweep){jobs[i]->pose.mechanism, &jobs[i]->plan, &((const findings *)jobs[i]->own)->sweep,
                                    jobs[i]->base};
  return km_mobility_plot(plotted, count, format, out, error);
}

static void free_own(kt_sweep_job *j) {
  findings *f = j->own;
  if (!f)
    return;
  km_mobility_sweep_free(&f->sweep);
  km_sweep_redundancies_free(&f->redundancies);
  km_free(f);
}

kt_exit kmob_sweep(int argc, char **argv) {
  static const kt_sweeping sweeping = {"mobility", NULL, run, print, rows, record, plot, free_own};
  options o = {.sweep = {.common = KT_COMMON("kmob")}};
  kt_options all = {0};
  const kt_option table[] = {
      KT_PATH_POINT(&o.sweep.points),
      {"singularities", 0, NULL,
       "Add the smallest kept singular value, and locate its minima: where mobility is nearly gained", KT_FLAG,
       &o.singularities, KT_ABOUT_MODEL},
  };
  kt_sweep_options_several(&all, &o.sweep, KT_SWEEP_BASE("mobility"));
  KT_OPTIONS_ADD(&all, table);
  kt_options_read(&all, "Mobility numbers of every joint over the range of a driver.", argc, argv);
  o.sweep.own = &o;
  return kt_sweep(&o.sweep, &sweeping);
}
