/* Writes the manual pages and the completions of the tools from what their commands know of themselves. */
#include "common/command_line/manual_pages.h"

#include "common/command_line/roff.h"
#include "kmech/version.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* Options that argp adds to every table. */
static const kt_option added[] = {
    {"help", '?', NULL, "Give a list of the options", {0}, NULL, KT_ABOUT_ALL},
    {"usage", 0, NULL, "Give a short usage message", {0}, NULL, KT_ABOUT_ALL},
    {"version", 'V', NULL, "Print the version", {0}, NULL, KT_ABOUT_ALL},
};

static void write_roff(const char *text, size_t length) {
  km_text roff = {0};
  kt_roff(text, length, &roff);
  if (roff.size)
    fputs(roff.data, stdout);
  km_text_free(&roff);
}

static void write_line(const char *before, const char *text) {
  fputs(before, stdout);
  write_roff(text, strlen(text));
  putchar('\n');
}

/* Paragraphs with a line feed, or several, between them. */
static void write_paragraphs(const char *text) {
  while (*text) {
    size_t length = strcspn(text, "\n\v");
    if (length) {
      fputs(".PP\n", stdout);
      write_roff(text, length);
      putchar('\n');
    }
    text += length + (text[length] != '\0');
  }
}

/* "kmob sweep" as a page's name: "kmob-sweep". */
static void page_name(const char *command, char out[64]) {
  snprintf(out, 64, "%s", command);
  for (char *c = out; *c; ++c)
    *c = *c == ' ' ? '-' : *c;
}

/* Its length without the full stop. */
static size_t first_sentence(const char *about) {
  size_t length = strcspn(about, "\n\v");
  for (size_t i = 0; i < length; ++i)
    if (about[i] == '.' && (i + 1 == length || about[i + 1] == ' '))
      return i;
  return length;
}

static void write_head(const char *name, const char *about) {
  char title[64];
  snprintf(title, sizeof title, "%s", name);
  for (char *c = title; *c; ++c)
    *c = (char)toupper((unsigned char)*c);
  printf(".TH %s 1 \"\" \"kmech %s\" \"kmech\"\n.SH NAME\n", title, KM_VERSION);
  write_roff(name, strlen(name));
  fputs(" \\- ", stdout);
  write_roff(about, first_sentence(about));
  putchar('\n');
}

static void write_option(const kt_option *o) {
  fputs(".TP\n", stdout);
  if (o->key)
    printf("\\fB\\-%c\\fR, ", o->key);
  fputs("\\fB\\-\\-", stdout);
  write_roff(o->name, strlen(o->name));
  fputs("\\fR", stdout);
  if (o->argument) {
    fputs("=\\fI", stdout);
    write_roff(o->argument, strlen(o->argument));
    fputs("\\fR", stdout);
  }
  write_line("\n", o->help);
}

static void write_end(const char *others) {
  fputs(".SH EXIT STATUS\n0 done; 1 done, but the answer is no or partial; 2 usage or files; 3 the model is bad; 4 an "
        "iteration didn't converge; 5 internal.\n.SH SEE ALSO\n",
        stdout);
  printf("%s.BR kmech (7),\n.BR kmech\\-model (5),\n.BR kmech\\-path\\-study (5),\n.BR kmech\\-study (5),\n"
         ".BR kmech\\-tables (5)\n",
         others);
}

static void print_manual(const kt_options *options, const char *command, const char *about) {
  char name[64], others[96];
  page_name(command, name);
  write_head(name, about);
  write_line(".SH SYNOPSIS\n.B ", command);
  fputs("[\\fIOPTION\\fR...]", stdout);
  if (options->operand.argument)
    printf(" \\fI%s\\fR", options->operand.argument);
  fputs("\n.SH DESCRIPTION\n", stdout);
  write_roff(about, strcspn(about, "\n\v"));
  putchar('\n');
  write_paragraphs(about + strcspn(about, "\n\v"));
  fputs(".SH OPTIONS\n", stdout);
  for (int i = 0; i < options->count; ++i)
    if (options->items[i].group != KT_HIDDEN)
      write_option(&options->items[i]);
  for (size_t i = 0; i < sizeof added / sizeof *added; ++i)
    write_option(&added[i]);
  snprintf(others, sizeof others, ".BR %.*s (1),\n", (int)strcspn(command, " "), command);
  write_end(others);
}

static void print_tool_manual(const char *tool, const char *about, const kt_command *commands) {
  write_head(tool, about);
  write_line(".SH SYNOPSIS\n.B ", tool);
  fputs("\\fICOMMAND\\fR [\\fIOPTION\\fR...] \\fIMODEL\\fR...\n.SH COMMANDS\n", stdout);
  for (const kt_command *c = commands; c->name; ++c) {
    printf(".TP\n.BR %s\\-%s (1)\n", tool, c->name);
    write_line("", c->summary);
  }
  fputs(".SH DESCRIPTION\nA model of \\- is the standard input. Results go to the standard output or into files, "
        "everything else to the standard error.\n.SH ENVIRONMENT\n.TP\n.B NO_COLOR\nMessages on a terminal without "
        "colours.\n.TP\n.B CLICOLOR_FORCE\nMessages with colours wherever they go.\n",
        stdout);
  write_end("");
}

static void write_names(const kt_option *o) {
  if (o->key)
    printf("-%c | ", o->key);
  printf("--%s", o->name);
}

static bool names_file(const kt_option *o) {
  return strcmp(o->argument, "FILE") == 0 || strcmp(o->argument, "BASE") == 0;
}

/* Completions of an option's argument: files, its choices, or none. */
static void write_offer(const kt_option *o) {
  fputs("      ", stdout);
  write_names(o);
  fputs(names_file(o) ? ") offer=files" : ") offer=words words='", stdout);
  for (const char *word = names_file(o) ? NULL : o->kind.words; word;) {
    const char *between = strstr(word, " or ");
    printf("%.*s", (int)(between ? between - word : (long)strlen(word)), word);
    word = between ? between + strlen(" or ") : NULL;
    fputs(word ? " " : "'", stdout);
  }
  fputs(names_file(o) || o->kind.words ? " ;;\n" : "' ;;\n", stdout);
}

/* A branch of the completion's `case` over the commands. */
static void print_completion(const kt_options *options, const char *command) {
  printf("  %s)\n    options='", strchr(command, ' ') + 1);
  for (int i = 0; i < options->count; ++i)
    if (options->items[i].group != KT_HIDDEN)
      printf("--%s ", options->items[i].name);
  fputs("--help --usage --version'\n    case $previous in\n", stdout);
  for (int i = 0; i < options->count; ++i)
    if (options->items[i].argument && options->items[i].group != KT_HIDDEN)
      write_offer(&options->items[i]);
  fputs("    esac\n    ;;\n", stdout);
}

bool kt_page_print(const kt_options *options, const char *command, const char *about, const char *word) {
  bool manual = strcmp(word, "man") == 0, completion = strcmp(word, "completion") == 0;
  if (manual)
    print_manual(options, command, about);
  if (completion)
    print_completion(options, command);
  return manual || completion;
}

bool kt_page_print_tool(const char *tool, const char *about, const kt_command *commands, const char *word) {
  bool manual = strcmp(word, "man") == 0, list = strcmp(word, "commands") == 0;
  if (manual)
    print_tool_manual(tool, about, commands);
  for (const kt_command *c = commands; c->name && list; ++c)
    puts(c->name);
  return manual || list;
}
