/* Sweeps several models at once and writes their tables and one plot. */
#include "common/sweep.h"

#include "base/parallel.h"
#include "exchange/json/json.h"
#include "report/record/csv.h"
#include "report/record/sweep_text.h"

#include <stdio.h>
#include <string.h>

typedef struct work {
  const kt_sweeping *sweeping;
  kt_sweep_job *jobs;
} work;

/* What the user should know of how the mechanism moved. */
static void tell(kt_sweep_job *j, const km_sweep *motion, bool partial) {
  const kt_common *common = &j->common;
  kt_detail(common, "%s: %zu rows of %zu columns", j->path, km_table_rows(motion->table),
            km_table_columns(motion->table));
  km_sweep_stop_text(j->pose.mechanism, &j->plan, motion, &j->stopped_by);
  if (partial && j->stopped_by.size)
    kt_say(common, KM_ERROR, "%s: %s", j->path, j->stopped_by.data);
  if (motion->start_branches > 0)
    kt_say(common, KM_NOTE,
           "%s: the starting pose is a branch point; of %d motions the one %s "
           "is taken (--set starts from another pose)",
           j->path, motion->start_branches,
           j->plan.arclength > 0.0 ? "nearest to the direction asked for" : "that moves the driver most");
  else if (motion->freedom > 1 && j->plan.arclength <= 0.0)
    kt_say(common, KM_NOTE, "%s: more than one freedom is left; the others move least (--hold keeps joints)", j->path);
}

static void run_sweep(kt_sweep_job *j, km_status (*run)(kt_sweep_job *, const km_sweep **, km_error *)) {
  kt_progress progress = kt_progress_start(&j->common);
  const km_sweep *motion = NULL;
  km_error error;
  j->plan.progress = kt_progress_show;
  j->plan.context = &progress;
  km_status status = run(j, &motion, &error);
  kt_progress_end(&progress);
  j->empty = status == KM_NO_RESULT;
  if ((status == KM_OK || status == KM_PARTIAL) && !j->empty)
    tell(j, motion, status == KM_PARTIAL);
  else
    kt_say(&j->common, KM_ERROR, "%s: %s", j->path, error.text);
  j->result = kt_exit_of(status);
}

void kt_sweep_job_open(kt_sweep_job *j, double metres) {
  const kt_sweep_options *o = j->options;
  kt_base_name(j->path, j->base, sizeof j->base);
  j->pose.model = kt_load(&j->common, j->path, &j->result);
  if (!j->pose.model)
    return;
  if (metres > 0.0)
    km_model_share_length(j->pose.model, metres / km_model_length_unit(j->pose.model));
  j->result = kt_bring(&j->common, j->path, &o->holds, &o->sets, &j->pose);
}

void kt_sweep_job_close(kt_sweep_job *j) {
  for (int i = 0; i < j->plan.point_count; ++i)
    km_free(j->names[i]);
  km_text_free(&j->stopped_by);
  kt_close(&j->pose);
}

void kt_sweep_job_run(kt_sweep_job *j, kt_exit (*prepare)(kt_sweep_job *),
                      km_status (*run)(kt_sweep_job *, const km_sweep **, km_error *)) {
  if (j->result == KT_DONE)
    j->result = kt_sweep_plan(j);
  if (j->result == KT_DONE && prepare)
    j->result = prepare(j);
  if (j->result == KT_DONE)
    run_sweep(j, run);
}

/* The first job is open already: its characteristic length serves all. */
static void start_job(void *context, int index) {
  const work *w = context;
  const kt_pose *first = &w->jobs[0].pose;
  if (index > 0)
    kt_sweep_job_open(w->jobs + index, first->mechanism ? km_mechanism_characteristic_length(first->mechanism, NULL) *
                                                              km_model_length_unit(first->model)
                                                        : 0.0);
  kt_sweep_job_run(w->jobs + index, w->sweeping->prepare, w->sweeping->run);
}

static bool delivers(const kt_sweep_job *j) {
  return (j->result == KT_DONE || j->result == KT_PARTIAL) && !j->empty;
}

static kt_exit write_table(const kt_sweeping *sweeping, const kt_sweep_job *j, const char *base, kt_format format) {
  km_text out = {0};
  if (format == KT_CSV) {
    km_csv_write(sweeping->table(j), &out);
  } else {
    km_arena arena = {0};
    const km_value *record = sweeping->record(j, &arena);
    if (record)
      km_json_write(record, &out);
    else
      out.failed = true;
    km_arena_free(&arena);
  }
  kt_exit result = kt_write(&j->options->common, base, sweeping->word, kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_plot(const kt_sweep_options *o, const work *w, const char *base, kt_format format) {
  const kt_sweep_job *shown[KT_MOST_MODELS];
  int count = 0;
  for (int i = 0; i < o->models.count; ++i)
    if (delivers(&w->jobs[i]))
      shown[count++] = &w->jobs[i];
  km_text out = {0};
  km_error error;
  km_status status = w->sweeping->plot(shown, count, kt_canvas_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_say(&o->common, KM_ERROR, "%s", error.text);
  else
    result = kt_write(&o->common, base, w->sweeping->word, kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

/* BASE: what -o says, else the first model's name, with `-compared` behind it where there are several. */
static void base_of(const kt_sweep_options *o, const work *w, char *out, size_t size) {
  if (o->base)
    snprintf(out, size, "%s", o->base);
  else
    snprintf(out, size, "%s%s", w->jobs[0].base, o->models.count > 1 ? "-compared" : "");
}

static kt_exit deliver(const kt_sweep_options *o, const work *w) {
  kt_exit result = KT_DONE;
  bool some = false;
  char base[4096], own[4096 + 256];
  base_of(o, w, base, sizeof base);
  for (int i = 0; i < o->models.count; ++i) {
    const kt_sweep_job *j = &w->jobs[i];
    if (!delivers(j))
      continue;
    some = true;
    km_text summary = {0};
    if (!o->common.quiet && !(o->base && strcmp(o->base, "-") == 0)) {
      w->sweeping->print(j, &summary);
      result = kt_worse(result, kt_print(&o->common, &summary));
    }
    km_text_free(&summary);
    snprintf(own, sizeof own, o->models.count > 1 ? "%s.%s" : "%s", base, j->base);
    for (int f = KT_CSV; f <= KT_JSON; ++f)
      if (o->formats.wanted[f])
        result = kt_worse(result, write_table(w->sweeping, j, own, (kt_format)f));
  }
  for (int f = KT_SVG; f <= KT_PNG && some; ++f)
    if (o->formats.wanted[f])
      result = kt_worse(result, write_plot(o, w, base, (kt_format)f));
  return result;
}

/* Tables are named after their models: two of one name would overwrite each other. */
static bool names_differ(const kt_sweep_options *o) {
  char a[256], b[256];
  for (int i = 0; i < o->models.count; ++i) {
    kt_base_name(o->models.items[i], a, sizeof a);
    for (int k = 0; k < i; ++k) {
      kt_base_name(o->models.items[k], b, sizeof b);
      if (strcmp(o->models.items[i], "-") == 0 && strcmp(o->models.items[k], "-") == 0) {
        kt_say(&o->common, KM_ERROR, "the standard input (-) is given twice; it can be read only once");
        return false;
      }
      if (strcmp(a, b) == 0) {
        kt_say(&o->common, KM_ERROR, "%s and %s would write the same files; expected models of different names",
               o->models.items[k], o->models.items[i]);
        return false;
      }
    }
  }
  return true;
}

static kt_exit run(const kt_sweep_options *o, const kt_sweeping *sweeping) {
  int count = o->models.count;
  work w = {sweeping, KM_NEW(kt_sweep_job, (size_t)count)};
  kt_exit result = KT_DONE;
  if (!w.jobs)
    return KT_INTERNAL;
  for (int i = 0; i < count; ++i) {
    kt_sweep_job *j = &w.jobs[i];
    j->options = o;
    j->path = o->models.items[i];
    j->common = o->common;
    j->common.log = count > 1 ? &j->log : NULL;
  }
  kt_sweep_job_open(&w.jobs[0], 0.0);
  km_parallel_for(count, o->common.jobs, start_job, &w);
  for (int i = 0; i < count; ++i) {
    kt_flush(&w.jobs[i].common);
    result = kt_worse(result, w.jobs[i].result);
  }
  result = kt_worse(result, deliver(o, &w));
  for (int i = 0; i < count; ++i) {
    sweeping->free(&w.jobs[i]);
    kt_sweep_job_close(&w.jobs[i]);
  }
  km_free(w.jobs);
  return result;
}

kt_exit kt_sweep(kt_sweep_options *o, const kt_sweeping *sweeping) {
  bool piped = o->base && strcmp(o->base, "-") == 0;
  if (!kt_formats_parse(&o->common, o->format ? o->format : piped ? "csv" : "csv,svg", &o->formats))
    return KT_USAGE;
  if (o->models.count > KT_MOST_MODELS)
    return kt_usage(&o->common, "MODEL", "…", "at most 64 models");
  bool tables_only = !o->formats.wanted[KT_SVG] && !o->formats.wanted[KT_PDF] && !o->formats.wanted[KT_PNG];
  if (piped && (o->models.count > 1 || kt_formats_count(&o->formats) != 1 || !tables_only))
    return kt_usage(&o->common, "-o", "-", "one model and --format csv or json");
  return names_differ(o) ? run(o, sweeping) : KT_USAGE;
}
