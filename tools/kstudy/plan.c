/* kstudy plan: what a run would cost, from a measured pilot. */
#include "kstudy/kstudy.h"

#include "kmech/base.h"

#include <math.h>
#include <sys/resource.h>

typedef struct pilot {
  double start, seconds;
} pilot;

/* The pilot ends after its time. */
static bool proceed(void *context, double done) {
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

/* Bytes of the pages that SQLite takes for a result of so many bytes: of one that is longer than a quarter of a page
 * it keeps the begin in the table, and the rest goes to pages of its own. */
static double stored(double record) {
  static const double page = 4096.0, longest = 1002.0, begin = 489.0, on_page = 4092.0, unused = 1.2;
  return record <= longest ? unused * record : begin + page * ceil((record - begin) / on_page);
}

static int band_rows(const kstudy_open *o, int question) {
  int rows = 0;
  if (o->def.questions[question].band_count)
    km_design_study_bands(o->study, question, 0, &rows, NULL, NULL, NULL);
  return rows;
}

/* Numbers of a design's answer, with its key. */
static double numbers_of(const kstudy_open *o, int question) {
  const km_design_question *q = &o->def.questions[question];
  return o->def.parameter_count + q->figure_count + (double)q->band_count * band_rows(o, question);
}

/* Bytes of so many designs in the store: of results by their keys, and of those that have been appended and wait, of
 * which more than a part never does. */
static double store_of(const kstudy_open *o, int designs) {
  static const double least_waiting = 1 << 20, waiting = 0.4, header = 10.0;
  double bytes = 0.0, appended = 0.0;
  for (int q = 0; q < o->def.question_count; ++q) {
    double record = header + 8.0 * numbers_of(o, q);
    bytes += designs * stored(record);
    appended += designs * record;
  }
  return bytes + fmin(appended, fmax(least_waiting, waiting * appended));
}

/* Peak memory of the pilot in bytes, without its results, which a run writes to a file. */
static double memory_of(const kstudy_open *o, int piloted) {
  struct rusage usage;
  double results = 0.0;
  for (int q = 0; q < o->def.question_count; ++q)
    results += 8.0 * piloted * numbers_of(o, q);
  return getrusage(RUSAGE_SELF, &usage) ? 0.0 : fmax(0.0, 1024.0 * (double)usage.ru_maxrss - results);
}

/* Memory of statistics in bytes: figures and ranks of up to KM_MAX_RANKED_DESIGNS designs, and one band at a time of
 * up to 10 000. */
static double statistics_of(const kstudy_open *o, int designs) {
  static const double banded = 10000.0, of_rank = 16.0;
  double ranked = fmin(designs, KM_MAX_RANKED_DESIGNS), bands = 0.0;
  int figures = km_design_study_figures(o->study);
  for (int q = 0; q < o->def.question_count; ++q)
    bands = fmax(bands, 8.0 * fmin(designs, banded) * (band_rows(o, q) + 1.0));
  return ranked * (8.0 * (figures + 1.0) + of_rank * (figures + o->def.parameter_count)) + bands;
}

static void print(const kstudy_open *o, double each, int piloted, int ranks, int jobs, km_text *out) {
  int designs = planned(o);
  double workers = (double)ranks * jobs;
  km_text_format(out, "%s: %s%d design%s\n", o->name, o->def.optimise ? "at most " : "", designs,
                 designs == 1 ? "" : "s");
  km_text_format(out, "  pilot: %d designs, %.4g ms each on one thread\n", piloted, 1e3 * each);
  km_text_format(out, "  time on %d rank%s of %d thread%s: about %.3g s\n", ranks, ranks == 1 ? "" : "s", jobs,
                 jobs == 1 ? "" : "s", each * designs / workers);
  km_text_format(out, "  memory on each rank: about %.2g MB; for statistics on the first about %.2g MB more\n",
                 1e-6 * memory_of(o, piloted), 1e-6 * statistics_of(o, designs));
  km_text_format(out, "  store: about %.2g MB\n", 1e-6 * store_of(o, designs));
}

/* The pilot's results go to a store of its own, in memory. */
static kt_exit measure(const kstudy_request *r, kstudy_open *o, double seconds, int ranks) {
  pilot p = {.start = kt_clock(), .seconds = seconds};
  km_error error;
  km_status status = km_design_study_run(o->study, 1, proceed, &p, &error);
  int computed = km_design_study_computed(o->study);
  if (status && status != KM_CANCELLED) {
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
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
  kt_exit result = kstudy_compile(&r, false, &o);
  if (result == KT_DONE)
    result = measure(&r, &o, 1.0, ranks);
  kstudy_close(&o);
  return result;
}
