/* Functions shared by the tools: common options, exit codes, messages, labels on the command line, output files. */
#ifndef KT_COMMON_H
#define KT_COMMON_H

#include "common/command_line/options.h"
#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/mechanism.h"
#include "kmech/report.h"
#include "kmech/rounding.h"

/* Exit codes of every tool. */
typedef enum kt_exit {
  KT_DONE = 0,
  KT_PARTIAL = 1,
  KT_USAGE = 2,
  KT_BAD_MODEL = 3,
  KT_GAVE_OUT = 4,
  KT_INTERNAL = 5,
  KT_NO_MEMORY = 6 /* inside a tool only: out of memory, not yet reported. kt_run reports it and exits with 5 */
} kt_exit;

kt_exit kt_exit_of(km_status status);
/* The more severe exit code of two parts of a command. */
kt_exit kt_worse(kt_exit a, kt_exit b);

/* Context of every command. */
typedef struct kt_common {
  const char *tool; /* prefix of messages */
  bool quiet, verbose, force;
  bool floating;            /* --float: bodies without a parent in a robot description are free */
  double closure_tolerance; /* --closure-tolerance; 0: the file's */
  bool exact;               /* --exact: rounded numbers are taken as written */
  int jobs;
  unsigned long seed;
  bool regular;               /* --regular of kmob convert */
  km_idealisation *idealised; /* receives the changes of rounded numbers; NULL: doesn't */
  int mode;                   /* --mode: assembly mode; 0: the file's own */
  const char *pose;           /* --pose: named pose of the model to start from; NULL: its own */
  km_messages *found; /* receives the reader's warnings and notes instead of the standard error; NULL: doesn't */
  km_text *log;       /* buffer of messages, so that parallel work reports in order; NULL: direct output */
} kt_common;

/* A tool's defaults. */
#define KT_COMMON(TOOL) ((kt_common){.tool = (TOOL), .jobs = 1, .seed = 1})

/* --quiet and --verbose; and, of --jobs, --seed, --force and how a model is read (--closure-tolerance, and --float
 * too where a robot description may be read), those that the command uses. */
enum { KT_USES_JOBS = 1, KT_USES_SEED = 2, KT_USES_FORCE = 4, KT_USES_MODEL = 8, KT_USES_FLOAT = 16 | KT_USES_MODEL };
void kt_common_options(kt_options *out, kt_common *common, unsigned uses);

/* `tool: text` on the standard error, coloured on a terminal (NO_COLOR, CLICOLOR_FORCE). Notes and warnings are
 * silent with --quiet. */
void kt_print_message(const kt_common *common, km_severity severity, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* `tool: text` on the standard error, with --verbose only. */
void kt_detail(const kt_common *common, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Prints the messages of a reader with the file name, and `text` if it failed without an error message. */
kt_exit kt_report_messages(const kt_common *common, const char *name, const km_messages *messages, km_status status,
                           const char *text);

/* `OPTION FOUND: expected EXPECTED`; KT_USAGE. */
kt_exit kt_usage(const kt_common *common, const char *option, const char *found, const char *expected);

/* Writes the gathered messages to the standard error. */
void kt_flush(kt_common *common);

/* Seconds of the monotonic clock. */
double kt_clock(void);

/* Installs handlers: the first Ctrl-C or SIGTERM ends long work with KM_CANCELLED, so that a command can write the
 * finished part; the second one ends the program. */
void kt_interrupts_catch(void);
void kt_interrupts_release(void);
bool kt_is_interrupted(void);

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
/* Reads a model with other values of some numbers. */
km_model *kt_load_varied(const kt_common *common, const char *path, const km_assignment *assignments, int count,
                         kt_exit *exit);
/* True if -o is the standard output; NULL: not given. */
bool kt_is_piped(const char *base);
/* Base name of a file: "models/brake.json" → "brake", "-" → "model". Written to the caller's buffer of `size`. */
void kt_base_name(const char *path, char *out, size_t size);
/* Base name of a study's output files: its file without extension, or its folder if the file is study.json; without
 * a file (NULL, "-") that of the model. */
void kt_study_base(const char *study, const char *model, char *out, size_t size);
/* The folder of a file: "" the current one. */
void kt_folder_of(const char *path, char *out, size_t size);

/* A piece of a command-line text up to an unescaped separator; backslashes before , = / [ are undone. */
typedef struct kt_piece {
  char *text;
  char separator; /* separator after the word; 0 at the end */
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

/* "60rpm" or a number in the coordinate's unit per time unit of the model; false where it is neither. */
bool kt_rate(const km_model *model, int coordinate, const char *text, double *out);

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
/* Checks that texts, which become column names, are unique; otherwise reports the duplicate. */
kt_exit kt_each_once(const kt_common *common, const char *option, char *const *texts, int count);
/* A decimal of at most 1e60 in size, with a sign, a point and an exponent where they are wanted; nothing else around
 * it. Every option's numbers are read by this. */
bool kt_number(const char *text, double *out);
/* Such a number that is whole and within bounds. */
bool kt_integer(const char *text, int least, int most, int *out);
/* Reads exactly `count` numbers separated by commas. */
bool kt_numbers(const char *text, int count, double *out);

/* File formats requested by --format. */
typedef enum kt_format {
  KT_CSV,
  KT_JSON,
  KT_XLSX,
  KT_SVG,
  KT_PDF,
  KT_PNG,
  KT_HTML,
  KT_APNG,
  KT_DXF,
  KT_FORMATS
} kt_format;
typedef struct kt_formats {
  bool wanted[KT_FORMATS];
} kt_formats;
#define KT_FORMATS_HELP "Some of csv,json,xlsx,svg,pdf,png (default csv,svg)"
#define KT_FORMATS_KIND KT_TEXT_OF("csv or json or xlsx or svg or pdf or png")
/* "csv,svg"; false and a message if a word is unknown. */
bool kt_formats_parse(const kt_common *common, const char *text, kt_formats *out);
/* File formats of a command that writes some of `among`, "svg,pdf,png". */
bool kt_formats_parse_among(const kt_common *common, const char *text, const char *among, kt_formats *out);
int kt_formats_count(const kt_formats *formats);
const char *kt_format_word(kt_format format);
km_picture_format kt_picture_format(kt_format format);

/* Records a file that the command reads; file options and operands are recorded when they are read. */
void kt_input(const char *path);
/* Writes a result, unless the file is one that the command reads; prints the path unless quiet. */
kt_exit kt_write_file(const kt_common *common, const char *path, const km_text *bytes);
/* Writes BASE.RESULT.FORMAT, or the standard output for base "-"; prints the path unless quiet. */
kt_exit kt_write(const kt_common *common, const char *base, const char *result, const char *format,
                 const km_text *bytes);
/* Warns before more than 100 MB are written: `numbers` numbers of about 20 bytes each. */
void kt_note_size(const kt_common *common, double numbers);
/* The name of a file that holds one of the `kinds` ("json or urdf"), the first one by default: *file (NULL and "-"
 * stay), with that ending in `room` where it has none and isn't a device or a pipe. KT_USAGE with a message for
 * another ending. */
enum { KT_FILE_ROOM = 4096 };
kt_exit kt_file_name(const kt_common *common, const char *kinds, const char **file, char room[KT_FILE_ROOM]);
/* The ending of the beginning of files' names where it is that of a kind of file that is in none of the `lists` (
 * NULL behind the last); NULL: none. */
const char *kt_foreign_ending(const char *base, const char *const *lists);

/* True if a file may be written: it is new, or --force is given; otherwise reports an error. Pipes and devices may
 * always be written. */
bool kt_may_write(const kt_common *common, const char *path);
/* Writes text or JSON to the standard output; control characters in names are escaped (km_text_visible). */
kt_exit kt_print(const kt_common *common, const km_text *text);
/* Writes a file's bytes as they are. */
kt_exit kt_print_bytes(const kt_common *common, const km_text *text);

#endif
