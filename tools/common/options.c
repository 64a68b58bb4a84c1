/* Reads command lines by tables of options: each becomes argp's own table and parser. */
#include "common/options.h"

#include "base/nearest.h"
#include "common/pages.h"

#include <argp.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Keys of options without a letter: beyond every character. */
enum { FIRST_KEY = 0x1000 };

void kt_options_add(kt_options *options, const kt_option *table, size_t count) {
  for (size_t i = 0; i < count && options->count < KT_MOST_OPTIONS; ++i)
    options->items[options->count++] = table[i];
}

static int key_of(const kt_options *options, int index) {
  return options->items[index].key ? options->items[index].key : FIRST_KEY + index;
}

static void keep_text(kt_texts *texts, char *text, struct argp_state *state) {
  if (texts->count == KT_MOST_TEXTS)
    argp_error(state, "an option is given more than %d times", KT_MOST_TEXTS);
  texts->items[texts->count++] = text;
}

int kt_word_place(const char *words, const char *text) {
  static const char between[] = " or ";
  size_t length = strlen(text);
  for (int place = 0;; ++place) {
    const char *end = strstr(words, between);
    size_t size = end ? (size_t)(end - words) : strlen(words);
    if (size == length && memcmp(words, text, size) == 0)
      return place;
    if (!end)
      return -1;
    words = end + sizeof between - 1;
  }
}

static void keep_word(const kt_option *o, const char *text, struct argp_state *state) {
  int place = kt_word_place(o->kind.words, text);
  if (place < 0)
    argp_error(state, "--%s %s: expected %s", o->name, text, o->kind.words);
  *(int *)o->target = place;
}

static void keep_count(const kt_option *o, const char *text, struct argp_state *state) {
  char *end = NULL;
  long count = strtol(text, &end, 10);
  if (*end || end == text || count < 1 || count > 1024)
    argp_error(state, "--%s: found \"%s\"; expected a whole number from 1 to 1024", o->name, text);
  *(int *)o->target = (int)count;
}

static void keep_seed(const kt_option *o, const char *text, struct argp_state *state) {
  char *end = NULL;
  errno = 0;
  unsigned long seed = strtoul(text, &end, 10);
  if (*end || end == text || *text == '-' || errno == ERANGE)
    argp_error(state, "--%s: found \"%s\"; expected a whole number of at least 0", o->name, text);
  *(unsigned long *)o->target = seed;
}

static void keep(const kt_option *o, char *text, struct argp_state *state) {
  switch (o->kind.keep) {
  case KT_KEEP_FLAG:
    *(bool *)o->target = true;
    break;
  case KT_KEEP_TEXT:
    *(const char **)o->target = text;
    break;
  case KT_KEEP_TEXTS:
    keep_text(o->target, text, state);
    break;
  case KT_KEEP_WORD:
    keep_word(o, text, state);
    break;
  case KT_KEEP_COUNT:
    keep_count(o, text, state);
    break;
  case KT_KEEP_SEED:
    keep_seed(o, text, state);
    break;
  }
}

static void keep_operand(const kt_operand *o, char *text, struct argp_state *state) {
  if (!o->noun)
    argp_error(state, "found \"%s\"; expected no argument", text);
  else if (o->several)
    keep_text(o->several, text, state);
  else if (*o->one)
    argp_error(state, "found a second %s \"%s\"; expected one", o->noun, text);
  else
    *o->one = text;
}

static error_t parse(int key, char *text, struct argp_state *state) {
  const kt_options *options = *(const kt_options **)state->input;
  if (key == ARGP_KEY_ARG) {
    keep_operand(&options->operand, text, state);
    return 0;
  }
  if (key == ARGP_KEY_NO_ARGS && options->operand.required)
    argp_error(state, "no %s is given", options->operand.noun);
  for (int i = 0; i < options->count; ++i)
    if (key == key_of(options, i)) {
      keep(&options->items[i], text, state);
      return 0;
    }
  return ARGP_ERR_UNKNOWN;
}

void kt_options_hide(kt_options *options, const char *name) {
  for (int i = 0; i < options->count; ++i)
    if (strcmp(options->items[i].name, name) == 0)
      options->items[i].group = KT_HIDDEN;
}

/* What argp knows beside the tables. */
static const char *const known[] = {"help", "usage", "version"};
enum { KNOWN = sizeof known / sizeof *known };

/* The option whose name begins with `text` up to its = or end, NULL for one of argp's own; false: there is none. */
static bool find_long(const kt_options *options, const char *text, const kt_option **out) {
  size_t length = strcspn(text, "=");
  *out = NULL;
  for (int i = 0; i < options->count; ++i)
    if (strncmp(options->items[i].name, text, length) == 0) {
      *out = &options->items[i];
      return true;
    }
  for (int i = 0; i < KNOWN; ++i)
    if (strncmp(known[i], text, length) == 0)
      return true;
  return false;
}

static bool takes_next(const kt_options *options, const char *text) {
  for (int i = 0; i < options->count && text[0] == '-' && text[1] && !text[2]; ++i)
    if (options->items[i].key == text[1])
      return options->items[i].argument != NULL;
  return false;
}

static void refuse_unknown(const kt_options *options, const char *command, const char *text) {
  char name[64], names[KM_NEAREST_TEXT];
  snprintf(name, sizeof name, "%.*s", (int)strcspn(text, "="), text);
  km_nearest nearest = {.wanted = name};
  for (int i = 0; i < options->count; ++i)
    if (options->items[i].group != KT_HIDDEN)
      km_nearest_offer(&nearest, options->items[i].name);
  for (int i = 0; i < KNOWN; ++i)
    km_nearest_offer(&nearest, known[i]);
  const kt_common common = KT_COMMON(command);
  kt_say(&common, KM_ERROR, "there is no option --%s; the nearest are %s (%s --help)", name,
         km_nearest_text(&nearest, names), command);
  exit(KT_USAGE);
}

/* argp tells only that an option is unknown; here the nearest ones are told. */
static void check_names(const kt_options *options, int argc, char **argv) {
  for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; ++i) {
    const kt_option *found = NULL;
    if (strncmp(argv[i], "--", 2) != 0) {
      i += takes_next(options, argv[i]);
      continue;
    }
    if (!find_long(options, argv[i] + 2, &found))
      refuse_unknown(options, argv[0], argv[i] + 2);
    if (found && found->argument && !strchr(argv[i], '='))
      ++i;
  }
}

static void print_page(const kt_options *options, const char *about, int argc, char **argv) {
  static const char help[] = "--help=";
  if (argc == 2 && strncmp(argv[1], help, sizeof help - 1) == 0 &&
      kt_page_print(options, argv[0], about, argv[1] + sizeof help - 1))
    exit(KT_DONE);
}

void kt_options_read(const kt_options *options, const char *about, int argc, char **argv) {
  print_page(options, about, argc, argv);
  check_names(options, argc, argv);
  struct argp_option table[KT_MOST_OPTIONS + 1] = {{0}};
  for (int i = 0; i < options->count; ++i) {
    const kt_option *o = &options->items[i];
    table[i] = (struct argp_option){o->name, key_of(options, i), o->argument, 0, o->help, (int)o->group};
    table[i].flags = o->group == KT_HIDDEN ? OPTION_HIDDEN : 0;
  }
  const struct argp argp = {.options = table, .parser = parse, .args_doc = options->operand.argument, .doc = about};
  if (argp_parse(&argp, argc, argv, 0, NULL, &options))
    exit(KT_USAGE);
}
