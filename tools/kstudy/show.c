/* kstudy show and export: what the store has. */
#include "common/report.h"
#include "kstudy/kstudy.h"

#include "kmech/data.h"
#include "kmech/report.h"

#include <string.h>

kt_exit kstudy_print(const kstudy_request *r, kstudy_open *o) {
  km_text out = {0};
  km_error error;
  km_status status = km_designs_print(o->study, &o->def, o->name, &out, &error);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
  kt_exit result = status ? kt_exit_of(status) : kt_print(&r->common, &out);
  km_text_free(&out);
  return result;
}

kt_exit kstudy_write_report(const kstudy_request *r, kstudy_open *o, const km_report_header *header, const char *file,
                            bool html) {
  const char *slash = strrchr(o->base, '/');
  km_text out = {0};
  km_error error;
  km_status status = km_designs_report(o->study, &o->def, slash ? slash + 1 : o->base, header, html, &out, &error);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
  kt_exit result = status ? kt_exit_of(status) : kt_report_write(&r->common, file, o->base, "study-report", html, &out);
  km_text_free(&out);
  return result;
}

static kt_exit recall(const kstudy_request *r, const kstudy_open *o) {
  km_error error;
  km_status status = km_design_study_lookup(o->study, &error);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
  return kt_exit_of(status);
}

/* Output without an answer of every design is partial. */
static kt_exit judge_answers(const kstudy_request *r, const kstudy_open *o) {
  km_design_yield y;
  if (km_design_study_is_complete(o->study))
    return KT_DONE;
  int missing = km_design_study_yield(o->study, &y, NULL) ? 0 : y.outcomes[KM_DESIGN_MISSING];
  if (missing)
    kt_print_message(&r->common, KM_WARNING,
                     "%s: the store has no answer of %d of %d designs; kstudy run asks for them", o->store, missing,
                     km_design_study_designs(o->study));
  else
    kt_print_message(&r->common, KM_WARNING,
                     "%s: the store ends before the optimisation does; kstudy run goes on with it", o->store);
  return KT_PARTIAL;
}

kt_exit kstudy_show(int argc, char **argv) {
  kstudy_request r = {.common = KT_COMMON("kstudy")};
  kstudy_open o;
  kt_formats formats = {{0}};
  kt_options all = {0};
  const kt_option table[] = {{"format", 0, "LIST", "Pictures too: some of svg,pdf,png (default none)",
                              KT_TEXT_OF("svg or pdf or png"), &r.format, KT_ABOUT_FILES}};
  KT_OPTIONS_ADD(&all, table);
  kstudy_options(&all, &r, 0);
  kt_options_read(&all, "Tables and plots of a study from its store, without asking anything.", argc, argv);
  if (r.format && !kt_formats_parse_among(&r.common, r.format, "svg,pdf,png", &formats))
    return KT_USAGE;
  kt_exit result = kstudy_compile(&r, true, &o);
  if (result == KT_DONE)
    result = recall(&r, &o);
  if (result == KT_DONE)
    result = kstudy_print(&r, &o);
  if (result == KT_DONE && r.format)
    result = kstudy_plot(&r, &o, &formats);
  if (result == KT_DONE)
    result = judge_answers(&r, &o);
  kstudy_close(&o);
  return result;
}

kt_exit kstudy_report(int argc, char **argv) {
  kstudy_request r = {.common = KT_COMMON("kstudy")};
  kstudy_open o;
  kt_options all = {0};
  kt_report_head head = {0};
  bool html;
  kt_report_word_options(&all, &head);
  const kt_option table[] = {
      {"format", 0, "FORMAT", "pdf (default) or html", KT_TEXT_OF("pdf or html"), &r.format, KT_ABOUT_FILES}};
  KT_OPTIONS_ADD(&all, table);
  kstudy_options(&all, &r, 0);
  kt_question_explain(
      &all, "base", "BASE",
      "Write this file if it ends with .pdf or .html, else BASE.study-report.FORMAT from the store of BASE "
      "(default: the study's name, or its folder's for study.json)");
  kt_options_read(&all,
                  "A report to hand on from the store: the best design beside the others or the start, spreads, limits "
                  "and pictures, as PDF pages or one HTML file.",
                  argc, argv);
  if (!kt_report_format(r.format, r.base, &html))
    return kt_usage(&r.common, "--format", r.format, "pdf or html, as -o says");
  if (kt_is_piped(r.base))
    return kt_usage(&r.common, "-o", "-", "a file");
  const char *file = r.base && kt_report_is_file(r.base) ? r.base : NULL;
  kt_exit result = kt_report_head_read(&r.common, &head);
  if (result != KT_DONE)
    return result;
  r.base = file ? NULL : r.base;
  result = kstudy_compile(&r, true, &o);
  if (result == KT_DONE)
    result = recall(&r, &o);
  if (result == KT_DONE)
    result = kt_report_head_complete(&r.common, &head, NULL, "");
  if (result == KT_DONE)
    result = kstudy_write_report(&r, &o, &head.header, file, html);
  if (result == KT_DONE)
    result = judge_answers(&r, &o);
  kstudy_close(&o);
  kt_report_head_free(&head);
  return result;
}

static kt_exit write_csv(const kstudy_request *r, const kstudy_open *o, const char *base) {
  km_text out = {0};
  km_error error;
  km_status status = km_designs_csv(o->study, &o->def, &out, &error);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
  kt_exit result = status ? kt_exit_of(status) : kt_write(&r->common, base, "study", "csv", &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_json(const kstudy_request *r, kstudy_open *o, const char *base) {
  km_text out = {0};
  km_arena arena = {0};
  km_error error;
  km_value *record;
  km_status status = km_designs_record(o->study, &o->def, o->name, &arena, &record, &error);
  if (!status)
    km_json_write(record, &out);
  else
    kt_print_message(&r->common, KM_ERROR, "%s: %s", o->name, error.text);
  kt_exit result = status ? kt_exit_of(status) : kt_write(&r->common, base, "study", "json", &out);
  km_text_free(&out);
  km_arena_free(&arena);
  return result;
}

kt_exit kstudy_export(int argc, char **argv) {
  kstudy_request r = {.common = KT_COMMON("kstudy")};
  kstudy_open o;
  kt_formats formats;
  kt_options all = {0};
  const kt_option table[] = {
      {"format", 0, "LIST", "csv (default) or json", KT_TEXT_OF("csv or json"), &r.format, KT_ABOUT_FILES}};
  KT_OPTIONS_ADD(&all, table);
  kstudy_options(&all, &r, 0);
  kt_options_read(&all,
                  "Every design of a study with its parameters, outcome and figures of merit, from its store, as "
                  "BASE.study.csv or .json; -o - is the standard output.",
                  argc, argv);
  if (!kt_formats_parse_among(&r.common, r.format ? r.format : "csv", "csv,json", &formats))
    return KT_USAGE;
  bool piped = kt_is_piped(r.base);
  if (piped && kt_formats_count(&formats) != 1)
    return kt_usage(&r.common, "-o", "-", "one format");
  kstudy_request named = r;
  named.base = piped ? NULL : r.base;
  kt_exit result = kstudy_compile(&named, true, &o);
  if (result == KT_DONE)
    result = recall(&r, &o);
  const char *base = piped ? "-" : o.base;
  if (result == KT_DONE && formats.wanted[KT_CSV])
    result = write_csv(&r, &o, base);
  if (result == KT_DONE && formats.wanted[KT_JSON])
    result = write_json(&r, &o, base);
  if (result == KT_DONE)
    result = judge_answers(&r, &o);
  kstudy_close(&o);
  return result;
}
