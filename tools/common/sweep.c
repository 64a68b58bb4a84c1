/* Asks several models one question at once and writes their tables and one plot. */
#include "common/sweep.h"

#include "base/parallel.h"
#include "exchange/json/json.h"
#include "report/plot/question_plot.h"
#include "report/record/csv.h"
#include "report/record/question_record.h"
#include "report/record/sweep_text.h"

#include <stdio.h>
#include <string.h>

/* What the user should know of how the mechanism moved. */
static void tell(kt_sweep_job *j, bool partial) {
  const kt_common *common = &j->common;
  const km_sweep *motion = km_question_motion(j->question);
  const km_sweep_plan *plan = km_question_plan(j->question);
  const km_statics_sweep *statics = km_question_statics(j->question);
  if (statics && statics->unheld)
    kt_say(common, KM_ERROR, "%s: the actuators can't hold %zu of %zu rows, first at %.9g (kstatic at tells why)",
           j->path, statics->unheld, km_table_rows(motion->table), statics->first_unheld);
  kt_detail(common, "%s: %zu rows of %zu columns", j->path, km_table_rows(motion->table),
            km_table_columns(motion->table));
  km_sweep_stop_text(j->pose.mechanism, plan, motion, &j->stopped_by);
  if (partial && j->stopped_by.size)
    kt_say(common, KM_ERROR, "%s: %s", j->path, j->stopped_by.data);
  if (motion->start_branches > 0)
    kt_say(common, KM_NOTE,
           "%s: the starting pose is a branch point; of %d motions the one %s "
           "is taken (--set starts from another pose)",
           j->path, motion->start_branches,
           plan->arclength > 0.0 ? "nearest to the direction asked for" : "that moves the driver most");
  else if (motion->freedom > 1 && plan->arclength <= 0.0)
    kt_say(common, KM_NOTE, "%s: more than one freedom is left; the others move least (--hold keeps joints)", j->path);
}

static void ask(kt_sweep_job *j) {
  kt_progress progress = kt_progress_start(&j->common);
  km_error error;
  km_question_watch(j->question, kt_progress_show, &progress);
  km_status status = km_question_ask(j->question, j->pose.state, &error);
  kt_progress_end(&progress);
  j->empty = status == KM_NO_RESULT;
  if (status == KM_OK || status == KM_PARTIAL)
    tell(j, status == KM_PARTIAL);
  else
    kt_say_asked(&j->common, KM_ERROR, j->path, error.text);
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
  km_question_free(j->question);
  km_text_free(&j->stopped_by);
  kt_close(&j->pose);
}

void kt_sweep_job_run(kt_sweep_job *j) {
  if (j->result == KT_DONE)
    j->result = kt_ask(&j->common, j->path, &j->options->asked, &j->pose, &j->question);
  if (j->result == KT_DONE)
    ask(j);
}

/* The first job is open already: its characteristic length serves all. */
static void start_job(void *context, int index) {
  kt_sweep_job *jobs = context;
  const kt_pose *first = &jobs[0].pose;
  if (index > 0)
    kt_sweep_job_open(jobs + index, first->mechanism ? km_mechanism_characteristic_length(first->mechanism, NULL) *
                                                           km_model_length_unit(first->model)
                                                     : 0.0);
  kt_sweep_job_run(jobs + index);
}

bool kt_sweep_job_delivers(const kt_sweep_job *j) {
  return (j->result == KT_DONE || j->result == KT_PARTIAL) && !j->empty;
}

/* What the result is called in the names of files. */
static const char *word_of(const kt_sweep_options *o) {
  return km_question_kind_name(o->asked.kind);
}

static kt_exit write_table(const kt_sweep_job *j, const char *base, kt_format format) {
  km_text out = {0};
  if (format == KT_CSV) {
    km_csv_write(km_question_table(j->question), &out);
  } else {
    km_arena arena = {0};
    const km_value *record = km_question_record(j->question, j->pose.mechanism,
                                                j->stopped_by.data ? j->stopped_by.data : "", j->path, &arena);
    if (record)
      km_json_write(record, &out);
    else
      out.failed = true;
    km_arena_free(&arena);
  }
  kt_exit result = kt_write(&j->options->common, base, word_of(j->options), kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_plot(const kt_sweep_options *o, const kt_sweep_job *jobs, const char *base, kt_format format) {
  km_answered shown[KT_MOST_MODELS];
  int count = 0;
  for (int i = 0; i < o->models.count; ++i)
    if (kt_sweep_job_delivers(&jobs[i]))
      shown[count++] = (km_answered){jobs[i].pose.mechanism, jobs[i].question, jobs[i].base};
  km_text out = {0};
  km_error error;
  km_status status = km_question_plot(shown, count, kt_canvas_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_say(&o->common, KM_ERROR, "%s", error.text);
  else
    result = kt_write(&o->common, base, word_of(o), kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

/* BASE: what -o says, else the first model's name, with `-compared` behind it where there are several. */
static void base_of(const kt_sweep_options *o, const kt_sweep_job *jobs, char *out, size_t size) {
  if (o->base)
    snprintf(out, size, "%s", o->base);
  else
    snprintf(out, size, "%s%s", jobs[0].base, o->models.count > 1 ? "-compared" : "");
}

static kt_exit deliver(const kt_sweep_options *o, const kt_sweep_job *jobs) {
  kt_exit result = KT_DONE;
  bool some = false;
  char base[4096], own[4096 + 256];
  base_of(o, jobs, base, sizeof base);
  for (int i = 0; i < o->models.count; ++i) {
    const kt_sweep_job *j = &jobs[i];
    if (!kt_sweep_job_delivers(j))
      continue;
    some = true;
    km_text summary = {0};
    if (!o->common.quiet && !(o->base && strcmp(o->base, "-") == 0)) {
      km_question_print(j->question, j->pose.mechanism, j->path, &summary);
      result = kt_worse(result, kt_print(&o->common, &summary));
    }
    km_text_free(&summary);
    snprintf(own, sizeof own, o->models.count > 1 ? "%s.%s" : "%s", base, j->base);
    for (int f = KT_CSV; f <= KT_JSON; ++f)
      if (o->formats.wanted[f])
        result = kt_worse(result, write_table(j, own, (kt_format)f));
  }
  for (int f = KT_SVG; f <= KT_PNG && some; ++f)
    if (o->formats.wanted[f])
      result = kt_worse(result, write_plot(o, jobs, base, (kt_format)f));
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

static kt_exit run(const kt_sweep_options *o) {
  int count = o->models.count;
  kt_sweep_job *jobs = KM_NEW(kt_sweep_job, (size_t)count);
  kt_exit result = KT_DONE;
  if (!jobs)
    return KT_INTERNAL;
  for (int i = 0; i < count; ++i) {
    jobs[i].options = o;
    jobs[i].path = o->models.items[i];
    jobs[i].common = o->common;
    jobs[i].common.log = count > 1 ? &jobs[i].log : NULL;
  }
  kt_sweep_job_open(&jobs[0], 0.0);
  km_parallel_for(count, o->common.jobs, start_job, jobs);
  for (int i = 0; i < count; ++i) {
    kt_flush(&jobs[i].common);
    result = kt_worse(result, jobs[i].result);
  }
  result = kt_worse(result, deliver(o, jobs));
  for (int i = 0; i < count; ++i)
    kt_sweep_job_close(&jobs[i]);
  km_free(jobs);
  return result;
}

kt_exit kt_sweep(kt_sweep_options *o) {
  bool piped = o->base && strcmp(o->base, "-") == 0;
  if (!kt_formats_parse(&o->common, o->format ? o->format : piped ? "csv" : "csv,svg", &o->formats))
    return KT_USAGE;
  if (o->formats.wanted[KT_JSON])
    kt_asked_set(&o->asked, "redundancies");
  if (o->models.count > KT_MOST_MODELS)
    return kt_usage(&o->common, "MODEL", "…", "at most 64 models");
  bool tables_only = !o->formats.wanted[KT_SVG] && !o->formats.wanted[KT_PDF] && !o->formats.wanted[KT_PNG];
  if (piped && (o->models.count > 1 || kt_formats_count(&o->formats) != 1 || !tables_only))
    return kt_usage(&o->common, "-o", "-", "one model and --format csv or json");
  return names_differ(o) ? run(o) : KT_USAGE;
}
