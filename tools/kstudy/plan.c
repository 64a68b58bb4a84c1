/* kstudy plan: what a run would cost, from a measured pilot. */
#include "kstudy/kstudy.h"

#include "kmech/text.h"

#include <math.h>
#include <sys/resource.h>

typedef struct pilot {
  double start, seconds;
} pilot;

/* The pilot ends after its time. */
static bool go_on(void *context, double done) {
  const pilot *p = context;
  (void)done;
  return kt_clock() - p->start < p->seconds;
}

static int planned(const kstudy_open *o) {
  const km_design_optimise *optimise = o->def.optimise;
  if (!optimise)
    return km_design_study_designs(o->study);
  return optimise->evaluations * (optimise->starts + (optimise->goal_count == 2 ? 2 : 0));
}

/* Bytes of a result in the store: key, figures, bands, and what SQLite adds. */
static double bytes_of(const kstudy_open *o) {
  double bytes = 0.0;
  for (int q = 0; q < o->def.question_count; ++q) {
    int rows = 0;
    const km_design_question *question = &o->def.questions[q];
    if (question->band_count)
      km_design_study_bands(o->study, q, 0, &rows, NULL, NULL, NULL);
    bytes += 24.0 + 8.0 * (o->def.parameter_count + question->figure_count + (double)question->band_count * rows);
  }
  return bytes;
}

/* What the pilot took at most, in bytes. Its own results are in memory; a run's go to a file. */
static double memory_of(const kstudy_open *o, int piloted) {
  struct rusage usage;
  return getrusage(RUSAGE_SELF, &usage) ? 0.0 : fmax(0.0, 1024.0 * (double)usage.ru_maxrss - bytes_of(o) * piloted);
}

static void print(const kstudy_open *o, double each, int piloted, int ranks, int jobs, km_text *out) {
  int designs = planned(o);
  double workers = (double)ranks * jobs;
  km_text_format(out, "%s: %s%d design%s\n", o->name, o->def.optimise ? "at most " : "", designs,
                 designs == 1 ? "" : "s");
  km_text_format(out, "  pilot: %d designs, %.4g ms each on one thread\n", piloted, 1e3 * each);
  km_text_format(out, "  time on %d rank%s of %d thread%s: about %.3g s\n", ranks, ranks == 1 ? "" : "s", jobs,
                 jobs == 1 ? "" : "s", each * designs / workers);
  km_text_format(out, "  memory on each rank: about %.2g MB, however many designs\n", 1e-6 * memory_of(o, piloted));
  km_text_format(out, "  store: about %.3g MB\n", 1e-6 * bytes_of(o) * designs);
}

/* The pilot's results go to a store of its own, in memory. */
static kt_exit measure(const kstudy_request *r, kstudy_open *o, double seconds, int ranks) {
  pilot p = {.start = kt_clock(), .seconds = seconds};
  km_error error;
  km_status status = km_design_study_run(o->study, 1, go_on, &p, &error);
  int computed = km_design_study_computed(o->study);
  if (status && status != KM_CANCELLED) {
    kt_say(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
    return kt_exit_of(status);
  }
  km_text out = {0};
  print(o, (kt_clock() - p.start) / (computed > 0 ? computed : 1), computed, ranks, r->common.jobs, &out);
  kt_exit result = kt_print(&r->common, &out);
  km_text_free(&out);
  return result;
}

kt_exit kstudy_plan(int argc, char **argv) {
  kstudy_request r = {.common = KT_COMMON("kstudy"), .store = ":memory:"};
  kstudy_open o;
  int ranks = 1;
  kt_options all = {0};
  const kt_option table[] = {
      {"ranks", 0, "N", "For N ranks, as mpirun -n N (default 1)", KT_COUNT, &ranks, KT_ABOUT_ALL}};
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &r.common, KT_USES_JOBS);
  all.operand = (kt_operand){"study", "STUDY", true, &r.study, NULL};
  kt_options_read(&all, "How many designs a study has, and how long they would take, from a pilot of one second.", argc,
                  argv);
  kt_exit result = kstudy_bring(&r, false, &o);
  if (result == KT_DONE)
    result = measure(&r, &o, 1.0, ranks);
  kstudy_close(&o);
  return result;
}
