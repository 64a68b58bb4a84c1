/* Sweeps one model and writes its report. */
#include "common/report.h"

#include "kmech/base.h"
#include "kmech/report.h"

#include <stdio.h>
#include <string.h>

void kt_report_options(kt_options *out, kt_sweep_options *o, const char *kind, const char *base_help) {
  const kt_option table[] = {
      {"title", 0, "TEXT", "Title in place of the report's own", KT_TEXT, &o->header.title, KT_ABOUT_FILES},
      {"author", 0, "TEXT", "Author, under the title", KT_TEXT, &o->header.author, KT_ABOUT_FILES},
      {"date", 0, "TEXT", "Date, under the title", KT_TEXT, &o->header.date, KT_ABOUT_FILES},
      {"note", 0, "TEXT", "A paragraph behind the answer", KT_TEXT, &o->header.note, KT_ABOUT_FILES},
      {"format", 0, "FORMAT", "pdf (default) or html", KT_TEXT_OF("pdf or html"), &o->format, KT_ABOUT_FILES},
      KT_BASE(&o->base, base_help),
  };
  kt_sweep_options_add(out, o, kind);
  KT_OPTIONS_ADD(out, table);
  kt_common_options(out, &o->common, KT_USES_FLOAT);
  kt_options_hide(out, "derivatives"); /* columns of tables, which a report doesn't have */
  kt_options_hide(out, "transmission");
  out->operand = (kt_operand){"model", "MODEL", true, NULL, &o->models};
}

static bool ends_with(const char *text, const char *end) {
  size_t a = strlen(text), b = strlen(end);
  return a > b && strcmp(text + a - b, end) == 0;
}

/* Format from --format or the file's extension; false if --format is invalid or contradicts the extension. */
static bool choose_format(const kt_sweep_options *o, bool *html) {
  bool named_html = o->base && ends_with(o->base, ".html"), named_pdf = o->base && ends_with(o->base, ".pdf");
  const char *word = o->format ? o->format : named_html ? "html" : "pdf";
  *html = strcmp(word, "html") == 0;
  return *html ? !named_pdf : strcmp(word, "pdf") == 0 && !named_html;
}

/* Writes the file that -o names, or BASE.WORD.FORMAT. */
static kt_exit write_file(const kt_sweep_job *j, bool html, const km_text *bytes) {
  char word[64];
  const kt_common *common = &j->options->common;
  const char *base = j->options->base, *format = html ? "html" : "pdf";
  snprintf(word, sizeof word, "%s-report", km_question_kind_name(j->options->asked.kind));
  if (!base || (!ends_with(base, ".pdf") && !ends_with(base, ".html")))
    return kt_write(common, base ? base : j->base, word, format, bytes);
  return kt_write_file(common, base, bytes);
}

static kt_exit deliver(const kt_sweep_job *j, bool html) {
  km_text out = {0};
  km_error error;
  km_answered answer = {.question = j->question, .name = j->label, .header = &j->options->header};
  km_status status = km_question_report(&answer, j->stopped_by.data ? j->stopped_by.data : "", html, &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&j->options->common, KM_ERROR, "%s: %s", j->path, error.text);
  else
    result = write_file(j, html, &out);
  km_text_free(&out);
  return result;
}

kt_exit kt_report(kt_sweep_options *o) {
  bool html;
  if (!choose_format(o, &html))
    return kt_usage(&o->common, "--format", o->format, "pdf or html, as -o says");
  if (o->models.count > 1)
    return kt_usage(&o->common, "MODEL", o->models.items[1], "one model for a report");
  if (kt_is_piped(o->base))
    return kt_usage(&o->common, "-o", "-", "a file");
  kt_question_set(&o->asked, "transmission");
  o->variants.count = 1;
  kt_sweep_job *j = KM_NEW(kt_sweep_job, 1);
  if (!j)
    return KT_NO_MEMORY;
  *j = (kt_sweep_job){.options = o, .path = o->models.items[0], .common = o->common};
  kt_sweep_job_name(j);
  kt_sweep_job_open(j, 0.0);
  kt_sweep_job_run(j);
  kt_exit result = j->result;
  if (kt_sweep_job_delivers(j))
    result = kt_worse(result, deliver(j, html));
  kt_sweep_job_close(j);
  km_free(j);
  return result;
}
