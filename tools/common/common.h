/* What the tools share: the common options, exit codes, messages, labels on the command line, output files. */
#ifndef KT_COMMON_H
#define KT_COMMON_H

#include "common/options.h"
#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/mechanism.h"
#include "kmech/report.h"

/* Exit codes of every tool (cli.md). */
typedef enum kt_exit {
  KT_DONE = 0,
  KT_PARTIAL = 1,
  KT_USAGE = 2,
  KT_BAD_MODEL = 3,
  KT_GAVE_OUT = 4,
  KT_INTERNAL = 5,
  KT_NO_MEMORY = 6 /* within a tool alone: memory is short, and nobody has said so. kt_run does, and ends with 5 */
} kt_exit;

kt_exit kt_exit_of(km_status status);
/* Of two parts of a command, the code that says more. */
kt_exit kt_worse(kt_exit a, kt_exit b);

/* What every command is told. */
typedef struct kt_common {
  const char *tool; /* how messages begin */
  bool quiet, verbose, force;
  bool floating;            /* of --float: what a robot description leaves untied is free */
  double closure_tolerance; /* of --closure-tolerance; 0: the file's */
  int jobs;
  unsigned long seed;
  int mode;           /* of --mode: the assembly mode that poses are brought to; 0: the file's own */
  const char *pose;   /* of --pose: the model's named pose to start from; NULL: its own */
  km_messages *found; /* receives the reader's warnings and notes instead of the standard error; NULL: doesn't */
  km_text *log;       /* where messages are gathered, so that parallel work reports in order; NULL: straight out */
} kt_common;

/* A tool's defaults. */
#define KT_COMMON(TOOL) ((kt_common){.tool = (TOOL), .jobs = 1, .seed = 1})

/* --quiet and --verbose; and, of --jobs, --seed, --force and how a model is read (--closure-tolerance, and --float
 * too where a robot description may be read), those that the command uses. */
enum { KT_USES_JOBS = 1, KT_USES_SEED = 2, KT_USES_FORCE = 4, KT_USES_MODEL = 8, KT_USES_FLOAT = 16 | KT_USES_MODEL };
void kt_common_options(kt_options *out, kt_common *common, unsigned uses);

/* `tool: text` on the standard error, coloured on a terminal (NO_COLOR, CLICOLOR_FORCE). Notes and warnings are
 * silent with --quiet. */
void kt_say(const kt_common *common, km_severity severity, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* `tool: text` on the standard error, with --verbose only. */
void kt_detail(const kt_common *common, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* What a reader found, with the file in front: its messages, and `text` where it failed without an error among them. */
kt_exit kt_tell_messages(const kt_common *common, const char *name, const km_messages *messages, km_status status,
                         const char *text);

/* `OPTION FOUND: expected EXPECTED`; KT_USAGE. */
kt_exit kt_usage(const kt_common *common, const char *option, const char *found, const char *expected);

/* Writes the gathered messages to the standard error. */
void kt_flush(kt_common *common);

/* Seconds since some moment, by a clock that nobody sets. */
double kt_clock(void);

/* A progress bar on the standard error: on a terminal only, and only after one second. */
typedef struct kt_progress {
  bool shown, drawn;
  double start, last;
} kt_progress;
kt_progress kt_progress_start(const kt_common *common);
bool kt_progress_show(void *context, double done); /* a km_progress; context: the kt_progress */
void kt_progress_end(kt_progress *progress);

/* One subcommand of a tool. */
typedef struct kt_command {
  const char *name, *summary;
  kt_exit (*run)(int argc, char **argv);
} kt_command;

/* Runs the subcommand that argv[1] names, with argv[0] as "tool name"; --help and --version of the tool. */
kt_exit kt_run(const char *tool, const char *about, const kt_command *commands, int argc, char **argv);

/* Reads a model and says what is wrong with it. NULL and *exit otherwise. The caller frees it. */
km_model *kt_load(const kt_common *common, const char *path, kt_exit *exit);
/* The same with other values for some of its numbers. */
km_model *kt_load_varied(const kt_common *common, const char *path, const km_assignment *assignments, int count,
                         kt_exit *exit);
/* Does -o ask for the standard output? NULL: it wasn't given. */
bool kt_is_piped(const char *base);
/* "models/brake.json" → "brake"; "-" → "model". Into the caller's buffer of `size`. */
void kt_base_name(const char *path, char *out, size_t size);
/* How a study's files are named: after its file without ending, or its folder where the file is called study.json;
 * without a file (NULL, "-") after the model. */
void kt_study_base(const char *study, const char *model, char *out, size_t size);
/* The folder of a file: "" the current one. */
void kt_folder_of(const char *path, char *out, size_t size);

/* A piece of a command-line text up to an unescaped separator; backslashes before , = / [ are undone. */
typedef struct kt_piece {
  char *text;
  char separator; /* what ended it, 0 at the end */
} kt_piece;
/* Splits off the first piece of *rest and moves *rest behind it. The caller frees piece.text. Where there is no
 * memory for a word of the command line, the tool says so and ends. */
kt_piece kt_split(const char **rest, const char *separators);
/* The text without its escapes, in the same way. */
char *kt_plain(const char *text);

/* label=value or label=v,v,v : the values of a joint's coordinates, in the model's units. */
typedef struct kt_setting {
  int coordinate;
  double value;
} kt_setting;

typedef struct kt_settings {
  kt_setting *items;
  int count;
} kt_settings;

/* Adds what `texts` (as given to --set or --hold) says; KT_USAGE with a message. */
kt_exit kt_settings_add(const kt_common *common, const km_model *model, const char *option, char **texts, int count,
                        kt_settings *out);
void kt_settings_free(kt_settings *settings);

/* Coordinates by a list of labels (LABEL,LABEL; a joint with several means all of them) into out[coordinates of the
 * model]. KT_USAGE if one is named twice or none is. */
kt_exit kt_coordinates(const kt_common *common, const km_model *model, const char *option, const char *text, int *out,
                       int *count);
/* A coordinate by its label on the command line. */
kt_exit kt_coordinate(const kt_common *common, const km_model *model, const char *option, const char *text,
                      int *coordinate);
/* A frame by BODY/FRAME on the command line. */
kt_exit kt_frame(const kt_common *common, const km_model *model, const char *option, const char *text, int *frame);
/* Each text gets columns of its own name: is each there once? Else says which isn't. */
kt_exit kt_each_once(const kt_common *common, const char *option, char *const *texts, int count);
/* A decimal of at most 1e60 in size, with a sign, a point and an exponent where they are wanted; nothing else around
 * it. Every option's numbers are read by this. */
bool kt_number(const char *text, double *out);
/* Such a number that is whole and within bounds. */
bool kt_whole(const char *text, int least, int most, int *out);
/* Just so many numbers with commas between them. */
bool kt_numbers(const char *text, int count, double *out);

/* Which files --format asks for. */
typedef enum kt_format { KT_CSV, KT_JSON, KT_SVG, KT_PDF, KT_PNG, KT_HTML, KT_APNG, KT_DXF, KT_FORMATS } kt_format;
typedef struct kt_formats {
  bool wanted[KT_FORMATS];
} kt_formats;
#define KT_FORMATS_HELP "Some of csv,json,svg,pdf,png (default csv,svg)"
#define KT_FORMATS_KIND KT_TEXT_OF("csv or json or svg or pdf or png")
/* "csv,svg"; false and a message if a word is unknown. */
bool kt_formats_parse(const kt_common *common, const char *text, kt_formats *out);
/* The same of a command that writes some of `among`, "svg,pdf,png". */
bool kt_formats_parse_among(const kt_common *common, const char *text, const char *among, kt_formats *out);
int kt_formats_count(const kt_formats *formats);
const char *kt_format_word(kt_format format);
km_picture_format kt_picture_format(kt_format format);

/* Remembers a file that the command reads; options and operands that are files are remembered as they are read. */
void kt_input(const char *path);
/* Writes a result, unless the file is one that the command reads; tells where unless quiet. */
kt_exit kt_write_file(const kt_common *common, const char *path, const km_text *bytes);
/* Writes BASE.RESULT.FORMAT, or the standard output for base "-"; tells where unless quiet. */
kt_exit kt_write(const kt_common *common, const char *base, const char *result, const char *format,
                 const km_text *bytes);
/* Tells before more than 100 MB are written: tables of so many numbers in all, each of some 20 bytes. */
void kt_note_size(const kt_common *common, double numbers);
/* The name of a file that holds one of the `kinds` ("json or urdf"), the first one by default: *file (NULL and "-"
 * stay), with that ending in `room` where it has none and isn't a device or a pipe. KT_USAGE with a message for
 * another ending. */
enum { KT_FILE_ROOM = 4096 };
kt_exit kt_file_name(const kt_common *common, const char *kinds, const char **file, char room[KT_FILE_ROOM]);
/* The ending of the beginning of files' names where it is that of a kind of file that is in none of the `lists` (
 * NULL behind the last); NULL: none. */
const char *kt_foreign_ending(const char *base, const char *const *lists);

/* Whether a file may be written under this name: it is new, or --force is given; says so if not. Pipes and devices may
 * always be written. */
bool kt_may_write(const kt_common *common, const char *path);
/* Writes text for people, or JSON, to the standard output; controls in names are shown (km_text_visible). */
kt_exit kt_print(const kt_common *common, const km_text *text);
/* Writes a file's bytes as they are. */
kt_exit kt_print_bytes(const kt_common *common, const km_text *text);

#endif
