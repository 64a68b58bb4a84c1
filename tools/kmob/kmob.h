/* Commands of kmob. */
#ifndef KMOB_H
#define KMOB_H

#include "common/pose.h"
#include "kmech/model.h"

kt_exit kmob_info(int argc, char **argv);
kt_exit kmob_at(int argc, char **argv);
kt_exit kmob_frame(int argc, char **argv);
kt_exit kmob_sweep(int argc, char **argv);
kt_exit kmob_motion(int argc, char **argv);
kt_exit kmob_allowance(int argc, char **argv);
kt_exit kmob_report(int argc, char **argv);
kt_exit kmob_graph(int argc, char **argv);
kt_exit kmob_check(int argc, char **argv);
kt_exit kmob_draw(int argc, char **argv);
kt_exit kmob_plot(int argc, char **argv);
kt_exit kmob_convert(int argc, char **argv);
kt_exit kmob_new(int argc, char **argv);
kt_exit kmob_schema(int argc, char **argv);

/* Options of the commands about one configuration (info, at, check). */
typedef struct kmob_request {
  kt_request pose;
  bool modes;  /* list the other assembly modes too */
  bool strict; /* hints count as findings */
} kmob_request;

/* Differences: info has no --set, check has --strict. */
typedef enum kmob_asking { KMOB_INFO, KMOB_AT, KMOB_CHECKS } kmob_asking;

/* Reads the options of such a command; usage errors end the process. */
kmob_request kmob_read_request(int argc, char **argv, const char *about, kmob_asking asking);

/* Output option of commands that write one file. */
#define KMOB_FILE(TARGET)                                                                                              \
  { "base", 'o', "FILE", "Write FILE instead of the standard output", KT_TEXT, TARGET, KT_ABOUT_FILES }

/* Writes a file, the standard output for NULL and "-"; says what failed. */
kt_exit kmob_write_text(const kt_common *common, const char *file, const km_text *text);
kt_exit kmob_write_value(const kt_common *common, const char *file, const km_value *value);

/* The units of a list such as `mm,deg` (NULL: none) in place of those given; says what isn't one. */
kt_exit kmob_choose_units(const kt_common *common, const char *list, km_units *units);

#endif
