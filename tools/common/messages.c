/* Errors, warnings and notes on the standard error, with colours on a terminal. */
#include "common/common.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* NO_COLOR and CLICOLOR_FORCE as other programs understand them; without them a terminal decides. */
static bool is_coloured(void) {
  const char *off = getenv("NO_COLOR"), *on = getenv("CLICOLOR_FORCE"), *terminal = getenv("TERM");
  if (off && *off)
    return false;
  if (on && *on && strcmp(on, "0") != 0)
    return true;
  return isatty(STDERR_FILENO) && terminal && strcmp(terminal, "dumb") != 0;
}

typedef struct style {
  const char *word, *tool_colour, *word_colour; /* SGR numbers; NULL: as the terminal has it */
} style;

/* Colours of the severities, and of details. */
static const style styles[] = {
    {"note: ", NULL, "1;36"}, {"warning: ", NULL, "1;33"}, {"", "1;31", NULL}, {"", NULL, NULL}};
enum { DETAIL = sizeof styles / sizeof *styles - 1 };

static void add(km_text *out, const char *text, const char *colour) {
  bool coloured = colour && is_coloured();
  if (coloured)
    km_text_format(out, "\033[%sm%s\033[0m", colour, text);
  else
    km_text_add(out, text);
}

static void report(const kt_common *common, const style *how, const char *format, va_list arguments) {
  char text[2 * KM_ERROR_TEXT], tool[64];
  km_text line = {0}, *out = common->log ? common->log : &line;
  vsnprintf(text, sizeof text, format, arguments);
  snprintf(tool, sizeof tool, "%s:", common->tool);
  add(out, tool, how->tool_colour);
  km_text_add(out, " ");
  add(out, how->word, how->word_colour);
  km_text_visible(out, text, strlen(text));
  km_text_add(out, "\n");
  if (line.failed)
    fprintf(stderr, "%s %s%s\n", tool, how->word, text);
  else if (!common->log)
    fwrite(line.data, 1, line.size, stderr);
  km_text_free(&line);
}

void kt_print_message(const kt_common *common, km_severity severity, const char *format, ...) {
  if (common->quiet && severity != KM_ERROR)
    return;
  va_list arguments;
  va_start(arguments, format);
  report(common, &styles[severity], format, arguments);
  va_end(arguments);
}

void kt_detail(const kt_common *common, const char *format, ...) {
  if (!common->verbose || common->quiet)
    return;
  va_list arguments;
  va_start(arguments, format);
  report(common, &styles[DETAIL], format, arguments);
  va_end(arguments);
}

kt_exit kt_usage(const kt_common *common, const char *option, const char *found, const char *expected) {
  kt_print_message(common, KM_ERROR, "%s %s: expected %s", option, found, expected);
  return KT_USAGE;
}

void kt_flush(kt_common *common) {
  if (common->log && common->log->size)
    fwrite(common->log->data, 1, common->log->size, stderr);
  if (common->log)
    km_text_free(common->log);
}

kt_exit kt_report_messages(const kt_common *common, const char *name, const km_messages *messages, km_status status,
                           const char *text) {
  bool told = false;
  for (size_t i = 0; i < km_messages_count(messages); ++i) {
    km_severity severity = km_messages_severity(messages, i);
    kt_print_message(common, severity, "%s: %s", name, km_messages_text(messages, i));
    told = told || severity == KM_ERROR;
  }
  if (status && !told)
    kt_print_message(common, KM_ERROR, "%s: %s", name, text);
  return kt_exit_of(status);
}
