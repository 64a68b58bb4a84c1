/* Common options, subcommands and reading of models for all tools. */
#include "common/common.h"

#include "common/command_line/manual_pages.h"
#include "kmech/base.h"
#include "kmech/version.h"

#include <argp.h>
#include <errno.h>
#include <stdio.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

kt_exit kt_exit_of(km_status status) {
  switch (status) {
  case KM_OK:
    return KT_DONE;
  case KM_PARTIAL:
  case KM_NO_RESULT:
    return KT_PARTIAL;
  case KM_USAGE:
  case KM_IO:
    return KT_USAGE;
  case KM_MODEL:
    return KT_BAD_MODEL;
  case KM_DIVERGED:
  case KM_CANCELLED:
    return KT_GAVE_OUT;
  default:
    return KT_INTERNAL;
  }
}

kt_exit kt_worse(kt_exit a, kt_exit b) {
  return a > b ? a : b;
}

void kt_common_options(kt_options *out, kt_common *common, unsigned uses) {
  const kt_option all[] = {
      {"quiet", 'q', NULL, "No notes, warnings, summaries or progress", KT_FLAG, &common->quiet, KT_ABOUT_ALL},
      {"verbose", 'v', NULL, "Tell the details of the work too", KT_FLAG, &common->verbose, KT_ABOUT_ALL},
  };
  const kt_option jobs[] = {{"jobs", 0, "N", "Work on up to N threads (default 1); results don't depend on it",
                             KT_COUNT, &common->jobs, KT_ABOUT_ALL}};
  const kt_option seed[] = {
      {"seed", 0, "N", "Seed of whatever is random (default 1)", KT_SEED, &common->seed, KT_ABOUT_ALL}};
  const kt_option force[] = {{"force", 0, NULL, "Replace a file that is there", KT_FLAG, &common->force, KT_ABOUT_ALL}};
  const kt_option floating[] = {{"float", 0, NULL,
                                 "The root link of a robot description is free to move, instead of fixed to the ground",
                                 KT_FLAG, &common->floating, KT_ABOUT_MODEL}};
  const kt_option tolerance[] = {
      {"closure-tolerance", 0, "X", "Close loops and judge ranks to within X, instead of the file's closure_tolerance",
       KT_TOLERANCE, &common->closure_tolerance, KT_ABOUT_MODEL},
      {"exact", 0, NULL, "Take rounded numbers as written, not the nearest mechanism that moves", KT_FLAG,
       &common->exact, KT_ABOUT_MODEL}};
  KT_OPTIONS_ADD(out, all);
  if (uses & KT_USES_MODEL)
    KT_OPTIONS_ADD(out, tolerance);
  if ((uses & KT_USES_FLOAT) == KT_USES_FLOAT)
    KT_OPTIONS_ADD(out, floating);
  if (uses & KT_USES_JOBS)
    KT_OPTIONS_ADD(out, jobs);
  if (uses & KT_USES_SEED)
    KT_OPTIONS_ADD(out, seed);
  if (uses & KT_USES_FORCE)
    KT_OPTIONS_ADD(out, force);
}

static void print_version(FILE *stream, struct argp_state *state) {
  (void)state;
  fprintf(stream, "kmech %s\n", KM_VERSION);
}

static void print_help(const char *tool, const char *about, const kt_command *commands) {
  size_t width = 9;
  for (const kt_command *c = commands; c->name; ++c)
    width = strlen(c->name) > width ? strlen(c->name) : width;
  printf("Usage: %s COMMAND [OPTION...] FILE...\n%s\n\n", tool, about);
  for (const kt_command *c = commands; c->name; ++c)
    printf("  %-*s %s\n", (int)width, c->name, c->summary);
  printf("\n`%s COMMAND --help` tells a command's options. A model of - is the standard input.\n"
         "Exit status: 0 done, 1 done but the answer is no or partial, 2 usage or files, 3 the model is bad,\n"
         "4 an iteration didn't converge, 5 internal.\n",
         tool);
}

/* Flushes the standard output, and reports a failure. */
static void close_output(void) {
  if (fflush(stdout) == 0 && !ferror(stdout))
    return;
  fprintf(stderr, "%s: standard output: can't be written\n", program_invocation_short_name);
  _exit(KT_USAGE);
}

static kt_exit report_memory(const char *tool, kt_exit result) {
  const kt_common common = KT_COMMON(tool);
  if (result != KT_NO_MEMORY)
    return result;
  kt_print_message(&common, KM_ERROR, "out of memory");
  return KT_INTERNAL;
}

kt_exit kt_run(const char *tool, const char *about, const kt_command *commands, int argc, char **argv) {
  atexit(close_output);
  /* OpenBLAS reads it when the first large mechanism loads it. Its own threads wait by spinning, and sums that they
   * share have other last digits on other machines. */
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  argp_err_exit_status = KT_USAGE;
  argp_program_version_hook = print_version;
  const char *word = argc > 1 ? argv[1] : "";
  if (strcmp(word, "--help") == 0 || strcmp(word, "-?") == 0) {
    print_help(tool, about, commands);
    return KT_DONE;
  }
  if (strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0) {
    print_version(stdout, NULL);
    return KT_DONE;
  }
  if (strncmp(word, "--help=", 7) == 0 && kt_page_print_tool(tool, about, commands, word + 7))
    return KT_DONE;
  for (const kt_command *c = commands; c->name; ++c) {
    if (strcmp(c->name, word) != 0)
      continue;
    char name[64];
    snprintf(name, sizeof name, "%s %s", tool, c->name);
    argv[1] = name;
    return report_memory(tool, c->run(argc - 1, argv + 1));
  }
  const kt_common common = KT_COMMON(tool);
  km_text names = {0};
  for (const kt_command *c = commands; c->name; ++c)
    km_text_format(&names, " %s", c->name);
  kt_print_message(&common, KM_ERROR, "%s%s%s; expected one of%s (%s --help)", argc > 1 ? "\"" : "no command", word,
                   argc > 1 ? "\" is not a command" : "", names.failed ? "" : names.data, tool);
  km_text_free(&names);
  return KT_USAGE;
}

km_model *kt_load(const kt_common *common, const char *path, kt_exit *status_out) {
  return kt_load_varied(common, path, NULL, 0, status_out);
}

km_model *kt_load_varied(const kt_common *common, const char *path, const km_assignment *assignments, int count,
                         kt_exit *status_out) {
  km_model *model = NULL;
  km_error error;
  km_messages *messages = km_messages_create();
  km_read_def def = {.assignments = assignments,
                     .assignment_count = count,
                     .floating = common->floating,
                     .closure_tolerance = common->closure_tolerance};
  km_status status = km_model_read_file_as(path, &def, messages, &model, &error);
  if (!status && !common->exact)
    status = km_model_idealise(model, common->regular, messages, common->idealised, &error);
  if (status) {
    km_model_free(model);
    model = NULL;
  }
  const char *name = strcmp(path, "-") == 0 ? "standard input" : path;
  for (size_t i = 0; i < km_messages_count(messages); ++i) {
    km_severity severity = km_messages_severity(messages, i);
    if (common->found && severity != KM_ERROR)
      km_messages_add(common->found, severity, "%s", km_messages_text(messages, i));
    else
      kt_print_message(common, severity, "%s: %s", name, km_messages_text(messages, i));
  }
  size_t kept = 0;
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    kept += km_messages_severity(messages, i) == KM_ERROR;
  if (km_messages_errors(messages) > kept)
    kt_print_message(common, KM_ERROR, "%s: and %zu more errors", name, km_messages_errors(messages) - kept);
  if (status == KM_USAGE && count > 0 && kept == 0)
    kt_print_message(common, KM_ERROR, "%s: --vary: %s", name, error.text);
  else if (status && kept == 0)
    kt_print_message(common, KM_ERROR, "%s", error.text);
  km_messages_free(messages);
  if (model)
    kt_detail(common, "%s: read %d bodies and %d joints", name, km_model_body_count(model),
              km_model_joint_count(model));
  *status_out = kt_exit_of(status);
  return model;
}

void kt_base_name(const char *path, char *out, size_t size) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  snprintf(out, size, "%s", strcmp(path, "-") == 0 ? "model" : name);
  char *dot = strrchr(out, '.');
  if (dot && dot != out)
    *dot = '\0';
}

void kt_study_base(const char *study, const char *model, char *out, size_t size) {
  kt_base_name(study && strcmp(study, "-") != 0 ? study : model, out, size);
  const char *slash = study ? strrchr(study, '/') : NULL;
  if (!study || strcmp(slash ? slash + 1 : study, "study.json") != 0)
    return;
  char *whole = realpath(study, NULL), *end = whole ? strrchr(whole, '/') : NULL;
  if (end)
    *end = '\0';
  const char *folder = whole ? strrchr(whole, '/') : NULL;
  if (folder && folder[1])
    snprintf(out, size, "%s", folder + 1);
  free(whole); /* the C library's */
}

void kt_folder_of(const char *path, char *out, size_t size) {
  const char *slash = strrchr(path, '/');
  snprintf(out, size, "%.*s", slash ? (int)(slash - path) : 0, path);
  if (slash == path)
    snprintf(out, size, "/");
}

kt_exit kt_print(const kt_common *common, const km_text *text) {
  km_text shown = {0};
  km_text_visible(&shown, text->data ? text->data : "", text->size);
  shown.failed = shown.failed || text->failed;
  kt_exit printed = kt_print_bytes(common, &shown);
  km_text_free(&shown);
  return printed;
}

kt_exit kt_print_bytes(const kt_common *common, const km_text *text) {
  km_error error;
  km_status status = km_file_write("-", text, &error);
  if (status) {
    kt_print_message(common, KM_ERROR, "%s", error.text);
    __fpurge(stdout); /* reported once */
    clearerr(stdout);
  }
  return kt_exit_of(status);
}
