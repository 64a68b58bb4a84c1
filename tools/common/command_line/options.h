/* Options of the command lines: tables of {name, key, argument, help, kind, target}, shared between commands, that
 * are parser and --help at once (argp underneath). */
#ifndef KT_COMMON_COMMAND_LINE_OPTIONS_H
#define KT_COMMON_COMMAND_LINE_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

enum { KT_MOST_TEXTS = 256, KT_MOST_OPTIONS = 48 };

/* Repeated options as they were given. */
typedef struct kt_texts {
  char *items[KT_MOST_TEXTS];
  int count;
} kt_texts;

/* Kind of an option's argument. */
typedef struct kt_kind {
  enum {
    KT_KEEP_FLAG,
    KT_KEEP_TEXT,
    KT_KEEP_INPUT,
    KT_KEEP_TEXTS,
    KT_KEEP_WORD,
    KT_KEEP_COUNT,
    KT_KEEP_SEED,
    KT_KEEP_BEGIN,
    KT_KEEP_TOLERANCE
  } keep;
  const char *words; /* choices of a WORD; completions of a text, or NULL */
} kt_kind;

#define KT_FLAG           ((kt_kind){KT_KEEP_FLAG, NULL})  /* no argument; target bool: it is given */
#define KT_TEXT           ((kt_kind){KT_KEEP_TEXT, NULL})  /* const char *: the text, the last one counts */
#define KT_TEXT_OF(WORDS) ((kt_kind){KT_KEEP_TEXT, WORDS}) /* several of the choices, separated by commas */
/* const char *: a file that is read, which no result replaces */
#define KT_INPUT ((kt_kind){KT_KEEP_INPUT, NULL})
#define KT_BEGIN                                                                                                       \
  ((kt_kind){KT_KEEP_BEGIN, NULL}) /* const char *: the beginning of files' names, which isn't a folder */
#define KT_TEXTS       ((kt_kind){KT_KEEP_TEXTS, NULL})     /* kt_texts: all texts in their order */
#define KT_WORD(WORDS) ((kt_kind){KT_KEEP_WORD, WORDS})     /* int: the word's place in "one or another" */
#define KT_COUNT       ((kt_kind){KT_KEEP_COUNT, NULL})     /* int: a whole number from 1 to 1024 */
#define KT_SEED        ((kt_kind){KT_KEEP_SEED, NULL})      /* unsigned long: a whole number of at least 0 */
#define KT_TOLERANCE   ((kt_kind){KT_KEEP_TOLERANCE, NULL}) /* double: above 0 and below 0.1 */

/* Section of --help; hidden options are accepted for old scripts and do nothing. */
typedef enum kt_group { KT_HIDDEN, KT_ABOUT_MODEL, KT_ABOUT_METHOD, KT_ABOUT_FILES, KT_ABOUT_ALL = 90 } kt_group;

typedef struct kt_option {
  const char *name;     /* name after -- */
  int key;              /* the letter behind -, or 0 */
  const char *argument; /* as --help shows it; NULL: none */
  const char *help;
  kt_kind kind;
  void *target; /* target of the kind's type */
  kt_group group;
} kt_option;

/* Operands of a command line. */
typedef struct kt_operand {
  const char *noun, *argument; /* "model", "MODEL" or "MODEL...": as messages and --help name it; NULL: none */
  bool required;
  const char **one;  /* its target, */
  kt_texts *several; /* or that of several */
} kt_operand;

/* The options of a command, gathered from the tables that it uses. */
typedef struct kt_options {
  kt_option items[KT_MOST_OPTIONS];
  int count;
  kt_operand operand;
} kt_options;

void kt_options_add(kt_options *options, const kt_option *table, size_t count);
/* List of options from an array. */
#define KT_OPTIONS_ADD(OPTIONS, TABLE) kt_options_add(OPTIONS, TABLE, sizeof(TABLE) / sizeof *(TABLE))

/* Leaves an option out of --help. */
void kt_options_hide(kt_options *options, const char *name);

/* Reads a command line into the targets; a usage error ends the process with KT_USAGE, --help and --version with 0
 * (and --help=man, --help=completion, from which manual_pages.h makes pages).
 * `about`: what the command does; text after \v stands below the options. */
void kt_options_read(const kt_options *options, const char *about, int argc, char **argv);

/* The place of `text` in "one or another or a third", -1 if it isn't there. */
int kt_word_place(const char *words, const char *text);

#endif
