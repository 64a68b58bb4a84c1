/* Commands of kspace. */
#ifndef KSPACE_H
#define KSPACE_H

#include "common/pose.h"

#include "kmech/clearance.h"
#include "kmech/data.h"
#include "kmech/space.h"

kt_exit kspace_clearance(int argc, char **argv);
kt_exit kspace_map(int argc, char **argv);
kt_exit kspace_modes(int argc, char **argv);
kt_exit kspace_path(int argc, char **argv);
kt_exit kspace_turning(int argc, char **argv);
kt_exit kspace_volume(int argc, char **argv);

/* The forms of an answer. */
typedef struct kspace_answer {
  const void *context;
  const km_value *(*record)(const void *context, km_arena *arena); /* NULL: out of memory */
  void (*print)(const void *context, km_text *out);
  kt_exit (*write)(const void *context, kt_format format, const km_text *record); /* the files of a format */
} kspace_answer;
/* The files of an answer. */
typedef struct kspace_files {
  const char *base; /* -o, or NULL: the answer is printed */
  kt_formats formats;
  char name[256]; /* BASE where --format states files without -o: the model's name */
} kspace_files;
/* Reads --format of a command that writes some of `among`; unless stated: csv, and svg if it is among them. False and a
 * message: invalid. */
bool kspace_read_formats(const kt_common *common, const char *format, const char *among, const char *model,
                         kspace_files *files);
/* Writes the files of `base`, unless it is NULL, in the formats, and prints the text, or the record if it is requested
 * and has no file. */
kt_exit kspace_deliver(const kt_common *common, const kspace_files *files, const kspace_answer *answer);

/* Reads --clearance: the pairs of bodies at the pose, and the least clearance. NULL without the option; free `*out` in
 * any case. */
kt_exit kspace_read_clearance(const kt_common *common, const char *text, const char *model, const kt_pose *pose,
                              km_clearance **out, double *least);

/* Prints how many joints beside the drivers have limits, which don't count; nothing if none has. */
void kspace_print_limits(const kt_pose *pose, const int *drivers, int count, km_text *out);

/* Adds `complete`, and the `reason` if there is a gap. */
void kspace_record_completeness(km_mode_gap gap, km_value *record, km_arena *arena);

/* Writes BASE.RESULT.csv. */
kt_exit kspace_write_csv(const kt_common *common, const char *base, const km_table *table, const char *result);

#endif
