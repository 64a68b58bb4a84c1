/* Computes a question for one model, several or variants, and writes a report. */
#include "common/report.h"

#include "kmech/base.h"
#include "kmech/report.h"

#include <stdio.h>
#include <string.h>

void kt_report_options(kt_options *out, kt_sweep_options *o, const char *kind, const char *base_help) {
  const kt_option several[] = {
      KT_VARY(&o->vary),
      {"over", 0, "QUANTITY",
       "Draw the curves over this instead of the driver or the time: a joint, BODY/FRAME.x, .y or .z of a point, or "
       "another column",
       KT_TEXT, &o->over, KT_ABOUT_FILES},
  };
  kt_sweep_options_add(out, o, kind);
  KT_OPTIONS_ADD(out, several);
  kt_report_head_options(out, &o->head, &o->format, &o->base, base_help);
  kt_common_options(out, &o->common, KT_USES_JOBS | KT_USES_FLOAT);
  kt_options_hide(out, "derivatives"); /* columns of tables, which a report doesn't have */
  kt_options_hide(out, "transmission");
  out->operand = (kt_operand){"model", "MODEL...", true, NULL, &o->models};
}

static bool ends_with(const char *text, const char *end) {
  size_t a = strlen(text), b = strlen(end);
  return a > b && strcmp(text + a - b, end) == 0;
}

bool kt_report_is_file(const char *base) {
  return ends_with(base, ".pdf") || ends_with(base, ".html");
}

bool kt_report_format(const char *format, const char *base, bool *html) {
  bool named_html = base && ends_with(base, ".html"), named_pdf = base && ends_with(base, ".pdf");
  const char *word = format ? format : named_html ? "html" : "pdf";
  *html = strcmp(word, "html") == 0;
  return *html ? !named_pdf : strcmp(word, "pdf") == 0 && !named_html;
}

kt_exit kt_report_write(const kt_common *common, const char *base, const char *name, const char *word, bool html,
                        const km_text *bytes) {
  if (!base || !kt_report_is_file(base))
    return kt_write(common, base ? base : name, word, html ? "html" : "pdf", bytes);
  return kt_write_file(common, base, bytes);
}

static kt_exit write_file(const kt_sweep_options *o, bool html, const km_text *bytes) {
  char word[64], base[4096];
  snprintf(word, sizeof word, "%s-report", km_question_kind_name(o->asked.kind));
  kt_sweep_base(o, base, sizeof base);
  return kt_report_write(&o->common, o->base, base, word, html, bytes);
}

/* "fourbar, brake and 2 more": the models in a title. */
static void name_models(const kt_sweep_options *o, km_text *out) {
  enum { MOST = 3 };
  char name[256];
  for (int i = 0; i < o->models.count && i < MOST; ++i) {
    kt_base_name(o->models.items[i], name, sizeof name);
    km_text_format(out, "%s%s", i ? ", " : "", name);
  }
  if (o->models.count > MOST)
    km_text_format(out, " and %d more", o->models.count - MOST);
}

/* Makes the report of one answer, or the comparison of several. */
static km_status make(const kt_sweep_options *o, const kt_sweep_job *jobs, int count, bool html, km_text *out,
                      km_error *error) {
  km_answered answers[KT_MOST_MODELS];
  const char *stopped_by[KT_MOST_MODELS];
  for (int i = 0; i < count; ++i) {
    answers[i] = (km_answered){.question = jobs[i].question, .name = jobs[i].label, .header = &o->head.header};
    stopped_by[i] = jobs[i].stopped_by.data ? jobs[i].stopped_by.data : "";
  }
  if (count == 1)
    return km_question_report(answers, stopped_by[0], html, out, error);
  km_text name = {0};
  const km_comparison comparison = {.answers = answers, .count = count, .ordered = o->variants.number_count > 0};
  name_models(o, &name);
  km_status status = name.failed
                         ? km_fail(error, KM_MEMORY, "out of memory for a report")
                         : km_comparison_report(&comparison, name.data, stopped_by, &o->head.header, html, out, error);
  km_text_free(&name);
  return status;
}

static kt_exit deliver(kt_sweep_options *o, const kt_sweep_job *jobs, int count) {
  bool html = false, some = false;
  kt_exit result = kt_report_head_complete(&o->common, &o->head, jobs[0].pose.model, jobs[0].path);
  o->head.header.over = o->over;
  kt_report_format(o->format, o->base, &html);
  for (int i = 0; i < count; ++i)
    some = some || kt_sweep_job_delivers(&jobs[i]);
  if (!some || result != KT_DONE)
    return result;
  km_text out = {0};
  km_error error;
  km_status status = make(o, jobs, count, html, &out, &error);
  result = kt_exit_of(status);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", jobs[0].path, error.text);
  else
    result = write_file(o, html, &out);
  km_text_free(&out);
  return result;
}

/* The point of --over BODY/FRAME.x is followed. */
static void follow_point(kt_sweep_options *o) {
  kt_texts *points = kt_question_texts(&o->asked, "point");
  if (!points)
    points = kt_question_texts(&o->asked, "frame");
  const size_t length = o->over ? strlen(o->over) : 0;
  const bool is_component = length > 2 && o->over[length - 2] == '.' && strchr("xyz", o->over[length - 1]) != NULL;
  if (!points || !is_component || !strchr(o->over, '/') || length > sizeof o->followed ||
      points->count >= KT_MOST_TEXTS)
    return;
  snprintf(o->followed, sizeof o->followed, "%.*s", (int)length - 2, o->over);
  for (int i = 0; i < points->count; ++i)
    if (strcmp(points->items[i], o->followed) == 0)
      return;
  points->items[points->count++] = o->followed;
}

kt_exit kt_report(kt_sweep_options *o) {
  bool html;
  if (!kt_report_format(o->format, o->base, &html))
    return kt_usage(&o->common, "--format", o->format, "pdf or html, as -o says");
  if (kt_is_piped(o->base))
    return kt_usage(&o->common, "-o", "-", "a file");
  kt_question_set(&o->asked, "transmission");
  follow_point(o);
  o->deliver = deliver;
  kt_exit result = kt_report_head_read(&o->common, &o->head);
  if (result == KT_DONE)
    result = kt_sweep_all(o);
  kt_report_head_free(&o->head);
  return result;
}
