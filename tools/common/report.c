/* Sweeps one model and writes its report. */
#include "common/report.h"

#include "kmech/base.h"
#include "kmech/report.h"

#include <stdio.h>
#include <string.h>

void kt_report_head_options(kt_options *out, km_report_header *header, const char **format, const char **base,
                            const char *base_help) {
  const kt_option table[] = {
      {"title", 0, "TEXT", "Title in place of the report's own", KT_TEXT, &header->title, KT_ABOUT_FILES},
      {"author", 0, "TEXT", "Author, under the title", KT_TEXT, &header->author, KT_ABOUT_FILES},
      {"date", 0, "TEXT", "Date, under the title", KT_TEXT, &header->date, KT_ABOUT_FILES},
      {"note", 0, "TEXT", "A paragraph behind the answer", KT_TEXT, &header->note, KT_ABOUT_FILES},
      {"format", 0, "FORMAT", "pdf (default) or html", KT_TEXT_OF("pdf or html"), format, KT_ABOUT_FILES},
      KT_BASE(base, base_help),
  };
  KT_OPTIONS_ADD(out, table);
}

void kt_report_options(kt_options *out, kt_sweep_options *o, const char *kind, const char *base_help) {
  kt_sweep_options_add(out, o, kind);
  kt_report_head_options(out, &o->header, &o->format, &o->base, base_help);
  kt_common_options(out, &o->common, KT_USES_FLOAT);
  kt_options_hide(out, "derivatives"); /* columns of tables, which a report doesn't have */
  kt_options_hide(out, "transmission");
  out->operand = (kt_operand){"model", "MODEL", true, NULL, &o->models};
}

static bool ends_with(const char *text, const char *end) {
  size_t a = strlen(text), b = strlen(end);
  return a > b && strcmp(text + a - b, end) == 0;
}

bool kt_report_format(const char *format, const char *base, bool *html) {
  bool named_html = base && ends_with(base, ".html"), named_pdf = base && ends_with(base, ".pdf");
  const char *word = format ? format : named_html ? "html" : "pdf";
  *html = strcmp(word, "html") == 0;
  return *html ? !named_pdf : strcmp(word, "pdf") == 0 && !named_html;
}

kt_exit kt_report_write(const kt_common *common, const char *base, const char *name, const char *word, bool html,
                        const km_text *bytes) {
  if (!base || (!ends_with(base, ".pdf") && !ends_with(base, ".html")))
    return kt_write(common, base ? base : name, word, html ? "html" : "pdf", bytes);
  return kt_write_file(common, base, bytes);
}

static kt_exit write_file(const kt_sweep_job *j, bool html, const km_text *bytes) {
  char word[64];
  snprintf(word, sizeof word, "%s-report", km_question_kind_name(j->options->asked.kind));
  return kt_report_write(&j->options->common, j->options->base, j->base, word, html, bytes);
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
  if (!kt_report_format(o->format, o->base, &html))
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
