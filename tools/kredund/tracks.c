/* Runs the methods of a study and writes their tables and pictures. */
#include "kredund/tracks.h"

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/report.h"

#include <stdio.h>
#include <string.h>

enum { OPTION_FORMAT = 0x3001 };

bool kredund_tracks_read(kt_options *all, const char *about, int argc, char **argv, kredund_request *r,
                         kt_formats *formats) {
  const kt_option files[] = {
      KT_POSE(r->common),
      {"format", 0, "LIST", KT_FORMATS_HELP, KT_FORMATS_KIND, &r->formats, KT_ABOUT_FILES},
      KT_BASE(&r->base,
              "Beginning of the files' names (default: the study's name, or its folder's for study.json); - is "
              "the standard output"),
  };
  kredund_arm_options(all, r);
  kredund_method_options(all, r);
  KT_OPTIONS_ADD(all, files);
  kt_common_options(all, &r->common, KT_USES_JOBS | KT_USES_SEED | KT_USES_MODEL);
  kt_options_read(all, about, argc, argv);
  bool piped = kt_is_piped(r->base);
  if (!kt_formats_parse(&r->common, r->formats ? r->formats : piped ? "csv" : "csv,svg", formats))
    return false;
  bool text = formats->wanted[KT_CSV] || formats->wanted[KT_JSON];
  if (piped && (kt_formats_count(formats) != 1 || !text)) {
    kt_usage(&r->common, "-o", "-", "--format csv or json");
    return false;
  }
  return true;
}

static void report_no_start(const kredund_tracks *t, const char *label) {
  km_error error = {0};
  km_study_start(t->open->study, NULL, NULL, &error);
  kt_print_message(&t->request->common, KM_ERROR, "%s: %s: nowhere to start, at s = 0, t = 0 s: %s", t->open->name,
                   label, error.text);
}

static void report_end(const kredund_tracks *t, int index) {
  const km_track *track = t->items[index];
  char label[64];
  km_text why = {0};
  km_tracks_label(&t->all, index, ' ', label, sizeof label);
  km_track_end_text(track, &why);
  if (km_track_ending(track).stop == KM_TRACK_START)
    report_no_start(t, label);
  else if (why.size)
    kt_print_message(&t->request->common, KM_ERROR, "%s: %s %s", t->open->name, label, why.data);
  if (km_track_summarise(track).greedy_instead)
    kt_print_message(&t->request->common, KM_NOTE,
                     "%s: %s isn't as good as greedy on this path; greedy's track is given", t->open->name, label);
  km_text_free(&why);
}

static kt_exit run_one(kredund_tracks *t, int index) {
  const kt_common *common = &t->request->common;
  kt_progress progress = kt_progress_start(common);
  km_track_plan plan = km_study_plan(t->open->study, index);
  km_error error;
  plan.jobs = common->jobs;
  plan.seed = common->seed;
  plan.progress = kt_progress_show;
  plan.context = &progress;
  km_status status = km_track_run(km_study_arm(t->open->study), &plan, &t->items[index], &error);
  kt_progress_end(&progress);
  if (t->items[index])
    report_end(t, index);
  else
    kt_print_message(common, KM_ERROR, "%s: %s: %s", t->open->name, plan.method.word, error.text);
  t->complete += status == KM_OK;
  return kt_exit_of(status);
}

kt_exit kredund_tracks_run(kredund_tracks *t) {
  kt_exit result = KT_DONE;
  t->count = km_study_methods(t->open->study);
  t->items = KM_NEW(km_track *, (size_t)t->count);
  t->all = (km_tracks){t->open->study, t->open->name, t->open->model_name, t->items, t->count};
  for (int i = 0; i < t->count && t->items; ++i)
    result = kt_worse(result, run_one(t, i));
  if (result == KT_PARTIAL && t->complete > 0)
    result = KT_DONE; /* the best gets to the end; that others don't is what several methods are for */
  return t->items ? result : KT_NO_MEMORY;
}

void kredund_tracks_free(kredund_tracks *t) {
  for (int i = 0; i < t->count && t->items; ++i)
    km_track_free(t->items[i]);
  km_free(t->items);
}

kt_exit kredund_write_table(const kredund_request *r, const kt_formats *formats, const char *base, const char *word,
                            const km_table *table) {
  kt_exit result = KT_DONE;
  km_text csv = {0}, book = {0};
  if (formats->wanted[KT_CSV]) {
    km_csv_write(table, &csv);
    result = kt_write(&r->common, base, word, "csv", &csv);
  }
  if (formats->wanted[KT_XLSX]) {
    km_error error;
    const km_status status = km_xlsx_write(table, word, "q.", &book, &error);
    if (status)
      kt_print_message(&r->common, KM_ERROR, "%s", error.text);
    result = kt_worse(result, status ? kt_exit_of(status) : kt_write(&r->common, base, word, "xlsx", &book));
  }
  km_text_free(&csv);
  km_text_free(&book);
  return result;
}

static kt_exit write_table(const kredund_tracks *t, int index, const char *name) {
  return kredund_write_table(t->request, &t->formats, name, "track", km_track_rows(t->items[index]));
}

/* BASE.track.csv or .xlsx; of several methods the best track's, and beside it BASE.METHOD.track.csv of each. */
static kt_exit write_tables(const kredund_tracks *t, const char *base) {
  kt_exit result = KT_DONE;
  int best = km_tracks_best(&t->all);
  for (int i = 0; i < t->count && t->count > 1; ++i) {
    char label[64], name[4096];
    if (!t->items[i])
      continue;
    km_tracks_label(&t->all, i, '-', label, sizeof label);
    snprintf(name, sizeof name, "%s.%s", base, label);
    result = kt_worse(result, write_table(t, i, name));
  }
  return best < 0 ? result : kt_worse(result, write_table(t, best, base));
}

static kt_exit write_record(const kredund_tracks *t, const char *base) {
  km_arena arena = {0};
  km_text out = {0};
  const km_value *record = km_tracks_record(&t->all, t->open->model, &arena);
  if (record)
    km_json_write(record, &out);
  else
    out.failed = true;
  km_arena_free(&arena);
  kt_exit result = kt_write(&t->request->common, base, "track", "json", &out);
  km_text_free(&out);
  return result;
}

kt_exit kredund_tracks_picture(const kredund_tracks *t, const char *base, const char *word, kt_format format,
                               kredund_draw draw) {
  km_text out = {0};
  km_error error;
  km_status status = draw(&t->all, kt_picture_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&t->request->common, KM_ERROR, "%s", error.text);
  else
    result = kt_write(&t->request->common, base, word, kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_page(const kredund_tracks *t, const char *base) {
  km_text out = {0};
  km_error error;
  km_status status = km_tracks_page(&t->all, &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&t->request->common, KM_ERROR, "%s: %s", t->open->name, error.text);
  else
    result = kt_write(&t->request->common, base, "motion", "html", &out);
  km_text_free(&out);
  return result;
}

static bool anything(const kredund_tracks *t) {
  for (int i = 0; i < t->count; ++i)
    if (t->items[i] && km_table_rows(km_track_rows(t->items[i])) > 1)
      return true;
  return false;
}

/* Number of numbers in the tables; the best track's table is written twice. */
static double count_numbers(const kredund_tracks *t) {
  double numbers = 0.0;
  int best = km_tracks_best(&t->all);
  for (int i = 0; i < t->count; ++i) {
    const km_table *table = t->items[i] ? km_track_rows(t->items[i]) : NULL;
    int tables = t->formats.wanted[KT_CSV] + t->formats.wanted[KT_XLSX];
    int copies = t->formats.wanted[KT_JSON] + tables * (1 + (i == best && t->count > 1));
    if (table)
      numbers += copies * (double)km_table_rows(table) * (double)km_table_columns(table);
  }
  return numbers;
}

kt_exit kredund_tracks_deliver(kredund_tracks *t, const char *base) {
  const kt_common *common = &t->request->common;
  kt_exit result = KT_DONE;
  bool map = t->map && km_arm_freedom(km_study_arm(t->open->study)) == 1;
  bool piped = kt_is_piped(base);
  if (piped && t->formats.wanted[KT_CSV] && t->count > 1)
    return kt_usage(common, "-o", "-", "one method with --format csv");
  if (!common->quiet && !piped) {
    km_text summary = {0};
    km_tracks_print(&t->all, &summary);
    result = kt_print(common, &summary);
    km_text_free(&summary);
  }
  kt_note_size(common, count_numbers(t));
  if (t->formats.wanted[KT_CSV] || t->formats.wanted[KT_XLSX])
    result = kt_worse(result, write_tables(t, base));
  if (t->formats.wanted[KT_JSON])
    result = kt_worse(result, write_record(t, base));
  for (int f = KT_SVG; f <= KT_PNG && anything(t); ++f) {
    if (!t->formats.wanted[f])
      continue;
    result = kt_worse(result, kredund_tracks_picture(t, base, "track", (kt_format)f, km_tracks_picture));
    result = kt_worse(result, kredund_tracks_picture(t, base, map ? "selfmotion" : "motion", (kt_format)f,
                                                     map ? km_tracks_map : km_tracks_drawing));
  }
  if (t->request->animate && anything(t))
    result = kt_worse(result, write_page(t, piped ? t->open->base : base));
  return result;
}

kt_exit kredund_tracks_command(const kredund_request *request, kt_formats formats, bool map) {
  kredund_open open;
  kredund_tracks tracks = {.request = request, .open = &open, .formats = formats, .map = map};
  kt_exit result = kredund_bind(request, true, &open);
  if (result == KT_DONE) {
    result = kredund_tracks_run(&tracks);
    if (result == KT_DONE || result == KT_PARTIAL)
      result = kt_worse(result, kredund_tracks_deliver(&tracks, request->base ? request->base : open.base));
  }
  kredund_tracks_free(&tracks);
  kredund_close(&open);
  return result;
}
