/* kstudy run and resume: evaluates the designs that the store doesn't have, and writes the results. */
#include "kstudy/kstudy.h"
#include "kstudy/ranks.h"

#include <signal.h>
#include <stdio.h>
#include <unistd.h>

/* Progress of the run: a bar on a terminal, ten times a second; otherwise one line a minute. */
typedef struct watch {
  const kt_common *common;
  bool terminal, drawn;
  double start, last;
} watch;

static void report(watch *w, double done, double time) {
  double spent = time - w->start, left = done > 0.0 ? spent * (1.0 - done) / done : 0.0;
  if (w->terminal) {
    int width = (int)(30.0 * done);
    fprintf(stderr, "\r%3.0f %% [%.*s%*s] %.0f s left ", 100.0 * done, width,
            "==============================", 30 - width, "", left);
    w->drawn = true;
  } else {
    kt_print_message(w->common, KM_NOTE, "%.1f %% done after %.0f s; about %.0f s left", 100.0 * done, spent, left);
  }
  w->last = time;
}

static bool draw(void *context, double done) {
  watch *w = context;
  double time = kt_clock();
  double wait = w->terminal ? 0.1 : 60.0, first = w->terminal ? 1.0 : 60.0;
  if (!w->common->quiet && time - w->start > first && time - w->last > wait)
    report(w, done, time);
  return !kt_is_interrupted();
}

static void watch_end(const watch *w) {
  if (w->drawn)
    fprintf(stderr, "\r%60s\r", "");
}

static kt_exit ask(const kstudy_request *r, const kstudy_open *o, const kstudy_ranks *ranks) {
  watch w = {.common = &r->common, .terminal = isatty(STDERR_FILENO), .start = kt_clock()};
  w.last = w.start;
  kt_interrupts_catch();
  km_error error;
  km_status status = ranks->count > 1
                         ? km_design_study_run_leader(o->study, r->common.jobs, &ranks->crew, draw, &w, &error)
                         : km_design_study_run(o->study, r->common.jobs, draw, &w, &error);
  watch_end(&w);
  kt_interrupts_release();
  int computed = km_design_study_computed(o->study), found = km_design_study_found(o->study);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s: %s%s", o->name, error.text,
                     status == KM_CANCELLED ? " (kstudy resume goes on)" : "");
  else
    kt_print_message(&r->common, KM_NOTE, "%s: %d design%s computed in %.3g s, %d %s in the store", o->name, computed,
                     computed == 1 ? "" : "s", kt_clock() - w.start, found, found == 1 ? "was" : "were");
  return status == KM_CANCELLED ? KT_PARTIAL : kt_exit_of(status);
}

static kt_exit deliver(const kstudy_request *r, kstudy_open *o, const kt_formats *formats) {
  kt_exit result = KT_DONE;
  if (!r->common.quiet)
    result = kstudy_print(r, o);
  result = kt_worse(result, kstudy_plot(r, o, formats));
  result = kt_worse(result, kstudy_write_report(r, o, NULL, NULL, true));
  return kt_worse(result, kstudy_write_models(r, o));
}

/* True if a design has an answer, and a value of every figure that can have one. */
static bool has_full_answer(const kstudy_open *o, int design) {
  km_design_result r;
  return !km_design_study_result(o->study, design, &r, NULL) && r.outcome == KM_DESIGN_DONE && !r.reason[0];
}

static kt_exit judge_variants(const kstudy_open *o) {
  bool full = true;
  for (int i = 0; i < km_design_study_designs(o->study); ++i)
    full = full && has_full_answer(o, i);
  return full ? KT_DONE : KT_PARTIAL;
}

/* 1: some variant has no full answer, none of a sample has any, or none is good enough. */
static kt_exit judge(kstudy_open *o) {
  km_design_yield y;
  if (km_design_study_yield(o->study, &y, NULL))
    return KT_DONE;
  if (o->def.optimise)
    return km_design_study_best(o->study) < 0 ? KT_PARTIAL : KT_DONE;
  if (!o->def.sample)
    return judge_variants(o);
  return y.outcomes[KM_DESIGN_DONE] + y.outcomes[KM_DESIGN_SHORT] > 0 ? KT_DONE : KT_PARTIAL;
}

/* Messages of the reader about the model as stated in its file; if it is invalid, those of the designs. */
static void report_remarks(const kstudy_request *r, const kstudy_open *o) {
  km_messages *messages = km_messages_create();
  km_model *model = NULL;
  km_error ignored;
  if (messages && !km_model_read_file(o->def.model, messages, &model, &ignored))
    kt_report_messages(&r->common, o->def.model, messages, KM_OK, "");
  km_model_free(model);
  km_messages_free(messages);
}

/* The first rank has the store and the files; it notifies the others at the end. */
static kt_exit lead(const kstudy_request *r, bool resume, const kt_formats *formats, const kstudy_ranks *ranks) {
  kstudy_open o;
  kt_exit result = kstudy_compile(r, resume, &o);
  if (result == KT_DONE) {
    report_remarks(r, &o);
    result = ask(r, &o, ranks);
  }
  if (result == KT_DONE)
    result = kt_worse(deliver(r, &o, formats), judge(&o));
  kstudy_close(&o);
  return result;
}

/* Errors of the study are reported by the first rank. */
static kt_exit serve(const kstudy_request *r, const kstudy_ranks *ranks) {
  kstudy_request quiet = *r;
  kstudy_open o;
  km_error error;
  quiet.store = ":memory:";
  quiet.common.quiet = true;
  signal(SIGINT, SIG_IGN); /* mpirun signals all ranks; the first one stops and ends the others */
  kt_exit result = kstudy_compile(&quiet, false, &o);
  km_status status =
      result == KT_DONE ? km_design_study_run_worker(o.study, r->common.jobs, &ranks->crew, &error) : KM_OK;
  if (status)
    kt_print_message(&r->common, KM_ERROR, "rank %d: %s", ranks->rank, error.text);
  kstudy_close(&o);
  return kt_worse(result, kt_exit_of(status));
}

static kt_exit run(int argc, char **argv, bool resume, const char *about) {
  kstudy_request r = {.common = KT_COMMON("kstudy")};
  kt_formats formats;
  kt_options all = {0};
  const kt_option table[] = {{"format", 0, "LIST", "Pictures as some of svg,pdf,png (default svg)",
                              KT_TEXT_OF("svg or pdf or png"), &r.format, KT_ABOUT_FILES}};
  KT_OPTIONS_ADD(&all, table);
  kstudy_options(&all, &r, KT_USES_JOBS | (resume ? 0 : KT_USES_FORCE));
  kt_options_read(&all, about, argc, argv);
  if (!kt_formats_parse_among(&r.common, r.format ? r.format : "svg", "svg,pdf,png", &formats))
    return KT_USAGE;
  kstudy_ranks ranks;
  kstudy_ranks_begin(&ranks);
  kt_exit result = ranks.rank == 0 ? lead(&r, resume, &formats, &ranks) : serve(&r, &ranks);
  kstudy_ranks_end(&ranks);
  return result;
}

kt_exit kstudy_run(int argc, char **argv) {
  return run(argc, argv, false,
             "Ask every design of a study its questions: figures of merit in a table, one picture a question, and the "
             "best design as a model. Results are kept in a store as they come: what is there isn't asked again.");
}

kt_exit kstudy_resume(int argc, char **argv) {
  return run(argc, argv, true, "Go on with a run that was stopped, from its store.");
}
