/* Reads command lines by tables of options: each becomes argp's own table and parser. */
#include "common/command_line/options.h"

#include "common/command_line/manual_pages.h"
#include "kmech/base.h"

#include <argp.h>
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Keys of options without a letter: beyond every character. */
enum { FIRST_KEY = 0x1000 };

void kt_options_add(kt_options *options, const kt_option *table, size_t count) {
  for (size_t i = 0; i < count && options->count < KT_MOST_OPTIONS; ++i)
    options->items[options->count++] = table[i];
}

/* A mistake on the command line, and where help is. */
static void refuse(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3), noreturn));
static void refuse(const char *command, const char *format, ...) {
  const kt_common common = KT_COMMON(command);
  va_list arguments;
  va_start(arguments, format);
  char words[KM_ERROR_TEXT];
  vsnprintf(words, sizeof words, format, arguments);
  va_end(arguments);
  kt_print_message(&common, KM_ERROR, "%s", words);
  fprintf(stderr, "Try `%s --help' or `%s --usage' for more information.\n", command, command);
  exit(KT_USAGE);
}

static int key_of(const kt_options *options, int index) {
  return options->items[index].key ? options->items[index].key : FIRST_KEY + index;
}

static void store_text(kt_texts *texts, char *text, struct argp_state *state) {
  if (texts->count == KT_MOST_TEXTS)
    refuse(state->name, "an option is given more than %d times", KT_MOST_TEXTS);
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

static void store_word(const kt_option *o, const char *text, struct argp_state *state) {
  int place = kt_word_place(o->kind.words, text);
  if (place < 0)
    refuse(state->name, "--%s %s: expected %s", o->name, text, o->kind.words);
  *(int *)o->target = place;
}

static void store_count(const kt_option *o, const char *text, struct argp_state *state) {
  if (!kt_integer(text, 1, 1024, o->target))
    refuse(state->name, "--%s: found \"%s\"; expected a whole number from 1 to 1024", o->name, text);
}

static void store_seed(const kt_option *o, const char *text, struct argp_state *state) {
  errno = 0;
  unsigned long seed = strtoul(text, NULL, 10);
  if (!*text || text[strspn(text, "0123456789")] || errno == ERANGE)
    refuse(state->name, "--%s: found \"%s\"; expected a whole number of at least 0", o->name, text);
  *(unsigned long *)o->target = seed;
}

static void store_tolerance(const kt_option *o, const char *text, struct argp_state *state) {
  double value;
  if (!kt_number(text, &value) || !(value > 0.0 && value < 0.1))
    refuse(state->name, "--%s: found \"%s\"; expected a number above 0 and below 0.1", o->name, text);
  *(double *)o->target = value;
}

/* A name may be that of a folder beside which the files come to lie; one that only a folder can have begins no
 * file's. */
static void store_begin(const kt_option *o, const char *text, struct argp_state *state) {
  const char *slash = strrchr(text, '/'), *last = slash ? slash + 1 : text;
  if (strcmp(last, "") == 0 || strcmp(last, ".") == 0 || strcmp(last, "..") == 0)
    refuse(state->name, "--%s %s: names a folder; expected the beginning of the files' names, as %s%sresult", o->name,
           text, text, *last ? "/" : "");
  *(const char **)o->target = text;
}

static void store(const kt_option *o, char *text, struct argp_state *state) {
  switch (o->kind.keep) {
  case KT_KEEP_FLAG:
    *(bool *)o->target = true;
    break;
  case KT_KEEP_TEXT:
    *(const char **)o->target = text;
    break;
  case KT_KEEP_INPUT:
    kt_input(text);
    *(const char **)o->target = text;
    break;
  case KT_KEEP_TEXTS:
    store_text(o->target, text, state);
    break;
  case KT_KEEP_WORD:
    store_word(o, text, state);
    break;
  case KT_KEEP_COUNT:
    store_count(o, text, state);
    break;
  case KT_KEEP_BEGIN:
    store_begin(o, text, state);
    break;
  case KT_KEEP_SEED:
    store_seed(o, text, state);
    break;
  case KT_KEEP_TOLERANCE:
    store_tolerance(o, text, state);
    break;
  }
}

static void store_operand(const kt_operand *o, char *text, struct argp_state *state) {
  kt_input(text);
  if (!o->noun)
    refuse(state->name, "found \"%s\"; expected no argument", text);
  else if (o->several)
    store_text(o->several, text, state);
  else if (*o->one)
    refuse(state->name, "found a second %s \"%s\"; expected one", o->noun, text);
  else
    *o->one = text;
}

static error_t parse(int key, char *text, struct argp_state *state) {
  const kt_options *options = *(const kt_options **)state->input;
  if (key == ARGP_KEY_ARG) {
    store_operand(&options->operand, text, state);
    return 0;
  }
  if (key == ARGP_KEY_NO_ARGS && options->operand.required)
    refuse(state->name, "no %s is given", options->operand.noun);
  for (int i = 0; i < options->count; ++i)
    if (key == key_of(options, i)) {
      store(&options->items[i], text, state);
      return 0;
    }
  return ARGP_ERR_UNKNOWN;
}

void kt_options_hide(kt_options *options, const char *name) {
  for (int i = 0; i < options->count; ++i)
    if (strcmp(options->items[i].name, name) == 0)
      options->items[i].group = KT_HIDDEN;
}

/* Data of argp beyond the tables. */
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

static void refuse_unknown(const kt_options *options, const char *command, const char *text) {
  char name[64], names[KM_NEAREST_TEXT];
  snprintf(name, sizeof name, "%.*s", (int)strcspn(text, "="), text);
  km_nearest nearest = {.wanted = name};
  for (int i = 0; i < options->count; ++i)
    if (options->items[i].group != KT_HIDDEN)
      km_nearest_add(&nearest, options->items[i].name);
  for (int i = 0; i < KNOWN; ++i)
    km_nearest_add(&nearest, known[i]);
  const kt_common common = KT_COMMON(command);
  kt_print_message(&common, KM_ERROR, "there is no option --%s; the nearest are %s (%s --help)", name,
                   km_nearest_text(&nearest, names), command);
  exit(KT_USAGE);
}

/* The option of a letter; NULL: none, or one of argp's own. */
static const kt_option *find_letter(const kt_options *options, char letter) {
  for (int i = 0; i < options->count; ++i)
    if (options->items[i].key == letter)
      return &options->items[i];
  return NULL;
}

/* Letters together, as -qv; the last one may take what follows, or the next argument, which is then skipped: true. */
static bool check_letters(const kt_options *options, const char *command, const char *text, const char *next) {
  for (const char *c = text + 1; *c; ++c) {
    const kt_option *o = find_letter(options, *c);
    if (!o && !strchr("?V", *c))
      refuse(command, "there is no option -%c", *c);
    if (o && o->argument && c[1])
      return false;
    if (o && o->argument && !next)
      refuse(command, "option -%c requires an argument", *c);
    if (o && o->argument)
      return true;
  }
  return false;
}

/* True: the next argument belongs to it. */
static bool check_long(const kt_options *options, const char *command, const char *text, const char *next) {
  const kt_option *found = NULL;
  bool given = strchr(text, '=') != NULL;
  if (!find_long(options, text, &found))
    refuse_unknown(options, command, text);
  if (found && !found->argument && given)
    refuse(command, "option --%s doesn't take an argument", found->name);
  if (found && found->argument && !given && !next)
    refuse(command, "option --%s requires an argument", found->name);
  return found && found->argument && !given;
}

/* argp and getopt report errors in their own form, and an unknown option without suggestions. */
static void check_names(const kt_options *options, int argc, char **argv) {
  for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; ++i) {
    const char *text = argv[i], *next = i + 1 < argc ? argv[i + 1] : NULL;
    if (strncmp(text, "--", 2) == 0)
      i += check_long(options, argv[0], text + 2, next);
    else if (text[0] == '-')
      i += check_letters(options, argv[0], text, next);
  }
}

static void print_page(const kt_options *options, const char *about, int argc, char **argv) {
  static const char help[] = "--help=";
  if (argc == 2 && strncmp(argv[1], help, sizeof help - 1) == 0 &&
      kt_page_print(options, argv[0], about, argv[1] + sizeof help - 1))
    exit(KT_DONE);
}

/* The ending of BASE says what the files hold, where it is that of a kind of file. */
static void check_base(const kt_options *options, const char *command) {
  const char *base = NULL, *words[KT_MOST_OPTIONS + 1] = {NULL};
  int count = 0;
  for (int i = 0; i < options->count; ++i) {
    const kt_option *o = &options->items[i];
    if (o->kind.keep == KT_KEEP_BEGIN)
      base = *(const char **)o->target;
    else if (strcmp(o->name, "format") == 0 && o->kind.words)
      words[count++] = kt_word_place(o->kind.words, "table") < 0 ? o->kind.words : "txt or json";
    else if (strcmp(o->name, "animate") == 0)
      words[count++] = "html or apng";
  }
  const char *foreign = base ? kt_foreign_ending(base, words) : NULL;
  if (foreign)
    refuse(command, "--base %s: this command writes no .%s; expected some of %s, or a name without such an ending",
           base, foreign, count ? words[0] : "its own files");
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
  check_base(options, argv[0]);
}
