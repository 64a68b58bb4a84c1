/* Computes one question for several models in parallel, and writes their tables and one plot. */
#include "common/sweep.h"

#include "common/drive_limits.h"
#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/report.h"

#include <stdio.h>
#include <string.h>

/* Actuators whose largest force along the sweep is more than their drives can give. */
static void report_drives(kt_sweep_job *j, const km_statics_sweep *statics) {
  const km_mechanism *m = j->pose.mechanism;
  for (int i = 0; i < statics->actuator_count; ++i) {
    const km_force_event *largest = &statics->largest[i];
    char where[80];
    snprintf(where, sizeof where, " at %.6g%s", largest->s, km_sweep_unit(m, km_question_plan(j->question)));
    kt_report_drive(&j->common, j->name, &j->pose, &statics->actuators[i], largest->value, where);
  }
}

/* Notes about the course of the motion. */
static void tell(kt_sweep_job *j, bool partial) {
  const kt_common *common = &j->common;
  const km_sweep *motion = km_question_motion(j->question);
  const km_sweep_plan *plan = km_question_plan(j->question);
  const km_statics_sweep *statics = km_question_statics(j->question);
  if (statics && statics->unheld)
    kt_print_message(common, KM_ERROR,
                     "%s: the actuators can't hold %zu of %zu rows, first at %.9g (kstatic at tells why)", j->name,
                     statics->unheld, km_table_rows(motion->table), statics->first_unheld);
  if (statics)
    report_drives(j, statics);
  kt_detail(common, "%s: %zu rows of %zu columns", j->name, km_table_rows(motion->table),
            km_table_columns(motion->table));
  km_sweep_stop_text(j->pose.mechanism, plan, motion, &j->stopped_by);
  if (partial && j->stopped_by.size)
    kt_print_message(common, KM_ERROR, "%s: %s", j->name, j->stopped_by.data);
  if (motion->start_branches == 1)
    kt_print_message(
        common, KM_NOTE,
        "%s: not all motions that first order allows at the starting pose are real; where the sweep ends early, hold a "
        "joint that stands in those that are (--hold)",
        j->name);
  else if (motion->start_branches > 0)
    kt_print_message(common, KM_NOTE,
                     "%s: the starting pose is a branch point; of %d motions the one %s "
                     "is taken (%s)",
                     j->name, motion->start_branches,
                     plan->arclength > 0.0 ? "nearest to the direction asked for" : "that moves the driver most",
                     plan->arclength > 0.0 ? "--direction asks for another one, --branch at the next branch point"
                                           : "--set starts from another pose");
  else if (motion->freedom - motion->passive - motion->infinitesimal > 1 && plan->arclength <= 0.0)
    kt_print_message(common, KM_NOTE, "%s: more than one freedom is left; the others move least (--hold keeps joints)",
                     j->name);
}

static void ask(kt_sweep_job *j) {
  kt_progress progress = kt_progress_start(&j->common);
  km_error error;
  km_question_observe(j->question, kt_progress_show, &progress);
  km_status status = km_question_compute(j->question, j->pose.state, &error);
  kt_progress_end(&progress);
  j->empty = status == KM_NO_RESULT;
  j->result = kt_exit_of(status);
  if (status != KM_OK && status != KM_PARTIAL)
    kt_print_messages(&j->common, KM_ERROR, j->name, error.text);
  else if (j->options->tell)
    j->result = j->options->tell(j);
  else
    tell(j, status == KM_PARTIAL);
}

/* A label without what file names or shells mind: "rise=40, tip.x=5" becomes "rise=40,tip.x=5". */
static void file_name(const char *label, char out[KT_JOB_NAME]) {
  for (; *label; ++label)
    if (*label == '/' || *label == ':')
      *out++ = *label == '/' ? '_' : '.';
    else if (*label != ' ')
      *out++ = *label;
  *out = '\0';
}

void kt_sweep_job_name(kt_sweep_job *j) {
  const kt_sweep_options *o = j->options;
  char model[256];
  bool varied = o->variants.number_count > 0, several = o->models.count > 1;
  kt_variant(&o->variants, j->variant, j->values, j->variant_name);
  kt_base_name(j->path, model, sizeof model);
  snprintf(j->name, sizeof j->name, varied ? "%s (%s)" : "%s", j->path, j->variant_name);
  snprintf(j->label, sizeof j->label, "%s%s%s", several || !varied ? model : "", several && varied ? ": " : "",
           j->variant_name);
  file_name(j->label, j->base);
}

void kt_sweep_job_open(kt_sweep_job *j, double metres) {
  const kt_sweep_options *o = j->options;
  j->pose.model = kt_load_varied(&j->common, j->path, j->values, o->variants.number_count, &j->result);
  if (!j->pose.model)
    return;
  if (metres > 0.0)
    km_model_share_length(j->pose.model, metres / km_model_length_unit(j->pose.model));
  j->result = kt_move_to_request(&j->common, j->name, &o->holds, &o->sets, &j->pose);
}

void kt_sweep_job_close(kt_sweep_job *j) {
  km_question_free(j->question);
  km_text_free(&j->stopped_by);
  km_free(j->shown);
  kt_close(&j->pose);
}

/* The coordinates of --joints. */
static kt_exit read_shown(kt_sweep_job *j) {
  j->shown = KM_NEW(int, (size_t)km_model_coordinate_count(j->pose.model) + 1);
  return j->shown ? kt_coordinates(&j->common, j->pose.model, "--joints", j->options->joints, j->shown, &j->shown_count)
                  : KT_NO_MEMORY;
}

void kt_sweep_job_run(kt_sweep_job *j) {
  if (j->result == KT_DONE)
    j->result = kt_compute_question(&j->common, j->name, &j->options->asked, &j->pose, &j->question);
  if (j->result == KT_DONE && j->options->joints)
    j->result = read_shown(j);
  if (j->result == KT_DONE)
    ask(j);
}

/* The first job is already open: all use its characteristic length. */
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
  return !j->empty && km_question_table(j->question);
}

/* Name of the result in file names. */
static const char *word_of(const kt_sweep_options *o) {
  return km_question_kind_name(o->asked.kind);
}

/* `variant` {path: value}, where there is one. */
static void add_variant(const kt_sweep_job *j, km_value *record, km_arena *arena) {
  int count = j->options->variants.number_count;
  km_value *variant = count ? km_value_add(arena, record, "variant", KM_OBJECT) : NULL;
  for (int i = 0; i < count && !arena->failed; ++i)
    km_value_number(arena, variant, j->values[i].path, j->values[i].value);
}

static kt_exit write_workbook(const kt_sweep_job *j, const char *base) {
  const kt_common *common = &j->options->common;
  km_text out = {0};
  km_error error;
  const km_status status = km_question_xlsx(j->question, word_of(j->options), &out, &error);
  if (status)
    kt_print_messages(common, KM_ERROR, j->name, error.text);
  const kt_exit result = status ? kt_exit_of(status) : kt_write(common, base, word_of(j->options), "xlsx", &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_table(const kt_sweep_job *j, const char *base, kt_format format) {
  km_text out = {0};
  if (format == KT_CSV) {
    km_csv_write(km_question_table(j->question), &out);
  } else {
    km_arena arena = {0};
    km_value *record = km_question_record(j->question, j->pose.mechanism, j->stopped_by.data ? j->stopped_by.data : "",
                                          j->path, &arena);
    if (record)
      add_variant(j, record, &arena);
    if (record && !arena.failed)
      km_json_write(record, &out);
    else
      out.failed = true;
    km_arena_free(&arena);
  }
  kt_exit result = kt_write(&j->options->common, base, word_of(j->options), kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static int job_count(const kt_sweep_options *o) {
  return o->models.count * o->variants.count;
}

static kt_exit write_plot(const kt_sweep_options *o, const kt_sweep_job *jobs, const char *base, kt_format format) {
  km_answered shown[KT_MOST_MODELS];
  km_comparison comparison = {.answers = shown, .ordered = o->variants.number_count > 0};
  for (int i = 0; i < job_count(o); ++i)
    if (kt_sweep_job_delivers(&jobs[i]))
      shown[comparison.count++] =
          (km_answered){jobs[i].question, jobs[i].label, jobs[i].shown, jobs[i].shown_count, NULL};
  km_text out = {0};
  km_error error;
  km_chart *chart = NULL;
  km_status status = km_question_chart(&comparison, &chart, &error);
  if (!status)
    status = km_chart_picture(chart, kt_picture_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_messages(&o->common, KM_ERROR, NULL, error.text);
  else
    result = kt_write(&o->common, base, word_of(o), kt_format_word(format), &out);
  km_chart_free(chart);
  km_text_free(&out);
  return result;
}

void kt_sweep_base(const kt_sweep_options *o, char *out, size_t size) {
  char model[256];
  kt_base_name(o->models.items[0], model, sizeof model);
  if (o->base)
    snprintf(out, size, "%s", o->base);
  else
    snprintf(out, size, "%s%s", model, job_count(o) > 1 ? "-compared" : "");
}

/* Number of numbers in the tables. */
static double count_numbers(const kt_sweep_options *o, const kt_sweep_job *jobs) {
  double numbers = 0.0;
  for (int i = 0; i < job_count(o); ++i) {
    const km_table *table = kt_sweep_job_delivers(&jobs[i]) ? km_question_table(jobs[i].question) : NULL;
    if (table)
      numbers += (double)km_table_rows(table) * (double)km_table_columns(table);
  }
  return numbers * (o->formats.wanted[KT_CSV] + o->formats.wanted[KT_JSON] + o->formats.wanted[KT_XLSX]);
}

static kt_exit write_results(const kt_sweep_options *o, const kt_sweep_job *jobs) {
  kt_exit result = KT_DONE;
  bool some = false;
  char base[4096], own[4096 + KT_JOB_NAME];
  kt_sweep_base(o, base, sizeof base);
  kt_note_size(&o->common, count_numbers(o, jobs));
  for (int i = 0; i < job_count(o); ++i) {
    const kt_sweep_job *j = &jobs[i];
    if (!kt_sweep_job_delivers(j))
      continue;
    some = true;
    km_text summary = {0};
    if (!o->common.quiet && !kt_is_piped(o->base)) {
      km_question_print(j->question, j->pose.mechanism, j->name, &summary);
      result = kt_worse(result, kt_print(&o->common, &summary));
    }
    km_text_free(&summary);
    snprintf(own, sizeof own, job_count(o) > 1 ? "%s.%s" : "%s", base, j->base);
    for (int f = KT_CSV; f <= KT_JSON; ++f)
      if (o->formats.wanted[f])
        result = kt_worse(result, write_table(j, own, (kt_format)f));
    if (o->formats.wanted[KT_XLSX])
      result = kt_worse(result, write_workbook(j, own));
    if (o->write_more)
      result = kt_worse(result, o->write_more(j, own));
  }
  for (int f = KT_SVG; f <= KT_PNG && some; ++f)
    if (o->formats.wanted[f])
      result = kt_worse(result, write_plot(o, jobs, base, (kt_format)f));
  return result;
}

/* Tables are named after their models and variants: two of one name would overwrite each other. */
static bool names_differ(const kt_sweep_options *o, const kt_sweep_job *jobs) {
  for (int i = 0; i < job_count(o); ++i)
    for (int k = 0; k < i; ++k)
      if (strcmp(jobs[i].base, jobs[k].base) == 0) {
        kt_print_message(
            &o->common, KM_ERROR, "%s and %s would write the same files; expected %s", jobs[k].name, jobs[i].name,
            strcmp(jobs[i].path, jobs[k].path) == 0 && jobs[i].variant_name[0] ? "variants that differ"
                                                                               : "models of different names");
        return false;
      }
  return true;
}

static bool one_standard_input(const kt_sweep_options *o) {
  int count = 0;
  for (int i = 0; i < o->models.count; ++i)
    count += strcmp(o->models.items[i], "-") == 0;
  if (count > 1)
    kt_print_message(&o->common, KM_ERROR, "the standard input (-) is given twice; it can be read only once");
  return count < 2;
}

/* Equal messages of variants are printed once: a wrong option is wrong for all. */
static void report_once(kt_sweep_job *jobs, int count) {
  for (int i = count - 1; i > 0; --i) {
    const km_text *last = &jobs[i - 1].log;
    km_text *log = &jobs[i].log;
    if (log->size == last->size && log->size > 0 && memcmp(log->data, last->data, log->size) == 0)
      km_text_free(log);
  }
}

static kt_exit run(kt_sweep_options *o, kt_sweep_job *jobs) {
  int count = job_count(o);
  kt_exit result = KT_DONE;
  kt_sweep_job_open(&jobs[0], 0.0);
  km_parallel_for(count, o->common.jobs, start_job, jobs);
  report_once(jobs, count);
  for (int i = 0; i < count; ++i) {
    kt_flush(&jobs[i].common);
    result = kt_worse(result, jobs[i].result);
  }
  result = kt_worse(result, o->deliver ? o->deliver(o, jobs, count) : write_results(o, jobs));
  for (int i = 0; i < count; ++i)
    kt_sweep_job_close(&jobs[i]);
  return result;
}

static kt_exit name_and_run(kt_sweep_options *o) {
  int count = job_count(o);
  kt_sweep_job *jobs = KM_NEW(kt_sweep_job, (size_t)count);
  if (!jobs)
    return KT_NO_MEMORY;
  for (int i = 0; i < count; ++i) {
    jobs[i].options = o;
    jobs[i].path = o->models.items[i / o->variants.count];
    jobs[i].variant = i % o->variants.count;
    jobs[i].common = o->common;
    jobs[i].common.log = count > 1 ? &jobs[i].log : NULL;
    kt_sweep_job_name(&jobs[i]);
  }
  kt_exit result = names_differ(o, jobs) ? run(o, jobs) : KT_USAGE;
  km_free(jobs);
  return result;
}

static kt_exit check(const kt_sweep_options *o) {
  bool piped = kt_is_piped(o->base);
  bool text = o->formats.wanted[KT_CSV] || o->formats.wanted[KT_JSON];
  if (piped && !o->deliver && (job_count(o) > 1 || kt_formats_count(&o->formats) != 1 || !text))
    return kt_usage(&o->common, "-o", "-", "one model and --format csv or json");
  for (int i = 0; i < o->models.count && o->variants.count > 1; ++i)
    if (strcmp(o->models.items[i], "-") == 0)
      return kt_usage(&o->common, "--vary", "with -", "a file: the standard input can be read only once");
  return one_standard_input(o) ? KT_DONE : KT_USAGE;
}

kt_exit kt_sweep(kt_sweep_options *o) {
  bool piped = kt_is_piped(o->base);
  if (!kt_formats_parse(&o->common, o->format ? o->format : piped ? "csv" : "csv,svg", &o->formats))
    return KT_USAGE;
  if (o->formats.wanted[KT_JSON])
    kt_question_set(&o->asked, "redundancies");
  return kt_sweep_all(o);
}

kt_exit kt_sweep_all(kt_sweep_options *o) {
  if (o->models.count > KT_MOST_MODELS)
    return kt_usage(&o->common, "MODEL", "…", "at most 64 models");
  kt_exit result = kt_variants_read(&o->common, &o->vary, KT_MOST_MODELS / o->models.count, &o->variants);
  if (result == KT_DONE)
    result = check(o);
  if (result == KT_DONE)
    result = name_and_run(o);
  kt_variants_free(&o->variants);
  return result;
}
