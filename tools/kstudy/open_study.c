/* Opens the study of the command line with its model, its sample and its store. */
#include "kstudy/kstudy.h"

#include "kmech/base.h"
#include "kmech/report.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

void kstudy_options(kt_options *out, kstudy_request *r, unsigned uses) {
  const kt_option table[] = {
      {"store", 0, "FILE", "Where results are kept (default BASE.study.sqlite)", KT_INPUT, &r->store, KT_ABOUT_FILES},
      KT_BASE(&r->base, "Beginning of the files' names (default: the study's name, or its folder's for study.json)"),
  };
  KT_OPTIONS_ADD(out, table);
  kt_common_options(out, &r->common, uses);
  out->operand = (kt_operand){"study", "STUDY", true, &r->study, NULL};
}

static kt_exit read_study(const kstudy_request *r, kstudy_open *out) {
  km_text text = {0};
  km_error error;
  km_messages *messages = km_messages_create();
  km_status status = km_file_read(r->study, &text, &error);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s", error.text);
  kt_exit result = kt_exit_of(status);
  if (!status) {
    status = km_design_study_read(text.data ? text.data : "", text.size, messages, &out->def, &error);
    result = kt_report_messages(&r->common, out->name, messages, status, error.text);
  }
  km_messages_free(messages);
  km_text_free(&text);
  return result;
}

static void beside_study(const char *study, const char *file, char *out, size_t size) {
  char folder[2048] = "";
  if (strcmp(study, "-") != 0)
    kt_folder_of(study, folder, sizeof folder);
  bool alone = file[0] == '/' || !folder[0];
  snprintf(out, size, "%s%s%s", alone ? "" : folder, alone ? "" : "/", file);
}

/* As the file has it: the numbers of parameters count in the model's units, so that what looks like a unit is a part
 * of the name. */
static const char *header_of(const km_table *table, size_t column, km_arena *arena) {
  const char *unit = km_table_unit(table, column);
  km_text name = {0};
  km_text_format(&name, "%s%s%s", km_table_name(table, column), unit[0] ? "_" : "", unit);
  return km_text_move_to_arena(&name, arena);
}

/* The columns of the sample's file are parameters by name; others are faults. */
static kt_exit copy_rows(const kstudy_request *r, kstudy_open *out, const km_table *table, const char *file) {
  int parameters = (int)km_table_columns(table);
  size_t rows = km_table_rows(table);
  km_design_parameter *list = KM_ARENA_NEW(&out->arena, km_design_parameter, KM_MAX_DESIGN_PARAMETERS);
  if (parameters > KM_MAX_DESIGN_PARAMETERS || rows == 0 || rows > 1000000000) {
    kt_print_message(&r->common, KM_ERROR,
                     "%s: found %d columns and %zu rows; expected up to %d columns and at least one row", file,
                     parameters, rows, KM_MAX_DESIGN_PARAMETERS);
    return KT_USAGE;
  }
  double *values = KM_ARENA_NEW(&out->arena, double, rows *(size_t)parameters);
  if (!values || !list)
    return KT_NO_MEMORY;
  for (int p = 0; p < parameters; ++p) {
    const char *name = header_of(table, (size_t)p, &out->arena);
    list[p] = (km_design_parameter){name, name};
    for (int k = 0; k < out->def.parameter_count; ++k)
      if (name && strcmp(out->def.parameters[k].name, name) == 0)
        list[p] = out->def.parameters[k];
  }
  for (size_t i = 0; i < rows; ++i)
    memcpy(values + i * (size_t)parameters, km_table_row(table, i), (size_t)parameters * sizeof *values);
  out->sample = *out->def.sample;
  out->sample.list = values;
  out->sample.count = (int)rows;
  out->def.sample = &out->sample;
  out->def.parameters = list;
  out->def.parameter_count = parameters;
  return KT_DONE;
}

static kt_exit read_rows(const kstudy_request *r, kstudy_open *out) {
  char file[4096];
  km_text text = {0};
  km_table *table = NULL;
  km_error error;
  if (!out->def.sample_file)
    return KT_DONE;
  beside_study(r->study, out->def.sample_file, file, sizeof file);
  kt_input(file);
  km_status status = km_file_read(file, &text, &error);
  if (!status)
    status = km_csv_read(&text, file, &table, &error);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s", error.text);
  kt_exit result = status ? kt_exit_of(status) : copy_rows(r, out, table, file);
  km_table_free(table);
  km_text_free(&text);
  return result;
}

/* Advice for a study that can't be opened. */
static const char *advice(const km_error *error, bool must_exist) {
  if (!strstr(error->text, "of another study"))
    return "";
  return must_exist ? " (kstudy run --force replaces them)" : " (--force replaces them)";
}

static kt_exit open_store(const kstudy_request *r, bool must_exist, kstudy_open *out) {
  struct stat there;
  km_error error;
  if (must_exist && (stat(out->store, &there) != 0 || there.st_size == 0)) {
    kt_print_message(&r->common, KM_ERROR, "%s: there is no such store; expected kstudy run before it", out->store);
    return KT_USAGE;
  }
  km_status status = km_design_study_open(&out->def, out->store, r->common.force, &out->study, &error);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s: %s%s", out->name, error.text, advice(&error, must_exist));
  return status == KM_USAGE && !strstr(error.text, "of another study") ? KT_BAD_MODEL : kt_exit_of(status);
}

kt_exit kstudy_compile(const kstudy_request *r, bool must_exist, kstudy_open *out) {
  *out = (kstudy_open){.def = km_design_study_default()};
  if (kt_is_piped(r->base))
    return kt_usage(&r->common, "-o", "-", "a name, as this command keeps several files");
  out->name = strcmp(r->study, "-") == 0 ? "standard input" : r->study;
  kt_exit result = read_study(r, out);
  if (result != KT_DONE)
    return result;
  beside_study(r->study, out->def.model, out->model, sizeof out->model);
  kt_input(out->model);
  out->def.model = out->model;
  if (strcmp(r->study, "-") != 0)
    kt_folder_of(r->study, out->folder, sizeof out->folder);
  out->def.folder = out->folder;
  if (r->base)
    snprintf(out->base, sizeof out->base, "%s", r->base);
  else
    kt_study_base(r->study, out->model, out->base, sizeof out->base);
  if (r->store)
    snprintf(out->store, sizeof out->store, "%.4095s", r->store);
  else
    snprintf(out->store, sizeof out->store, "%.4090s.study.sqlite", out->base);
  result = read_rows(r, out);
  if (result == KT_DONE)
    result = kstudy_check_names(r, out);
  return result == KT_DONE ? open_store(r, must_exist, out) : result;
}

void kstudy_close(kstudy_open *open) {
  km_design_study_free(open->study);
  km_design_study_def_free(&open->def);
  km_arena_free(&open->arena);
}
