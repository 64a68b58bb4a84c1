/* ksim's commands. */
#ifndef KSIM_H
#define KSIM_H

#include "common/common.h"
#include "common/pose.h"

#include "kmech/data.h"
#include "kmech/dynamics.h"
#include "kmech/report.h"

kt_exit ksim_run(int argc, char **argv);
kt_exit ksim_inverse(int argc, char **argv);
kt_exit ksim_linearise(int argc, char **argv);
kt_exit ksim_equilibrium(int argc, char **argv);
kt_exit ksim_serve(int argc, char **argv);

/* A positive number of an option; what isn't given stays. */
kt_exit ksim_read_number(const kt_common *common, const char *option, const char *text, const char *expected,
                         double *out);
/* BODY/FRAME of --frame; the caller frees `*out` (km_free). */
kt_exit ksim_read_frames(const kt_common *common, const km_model *model, const kt_texts *texts,
                         const km_traced_frame **out, int *count);
/* Gravity, springs and the model's own loads. The caller frees `*out`. */
kt_exit ksim_forces(const kt_common *common, const char *path, const kt_pose *pose, km_forces **out);

/* "60rpm" or a number in the model's unit per time unit; false where it is neither. */
bool ksim_read_rate(const km_model *model, int coordinate, const char *text, double *out);

/* Names joints that turn without friction, since theirs has no radius. */
void ksim_report_hinges(const kt_common *common, const char *path, const km_model *model);
/* Warns of joints that pass limits where no stop acts; KT_PARTIAL where there are some. */
kt_exit ksim_report_limits(const kt_common *common, const char *path, const kt_pose *pose, const km_history *history);
/* Prints gravity, and what the reactions omit. */
void ksim_print_acting(bool reactions, const km_model *model, km_text *out);
/* Warns of drives that went beyond their joints' bounds. */
void ksim_report_drives(const kt_common *common, const char *path, const kt_pose *pose, const km_history *history);

/* A table over time on its way to BASE.WORD.FORMAT and the standard output. Borrowed, but for what `record` makes in
 * the arena that it is given, and the plot that `chart` makes; `context` is theirs. */
typedef struct ksim_delivery {
  const kt_common *common;
  const kt_formats *formats;
  const char *base, *word;
  const km_table *table;
  const km_text *summary;
  const km_value *(*record)(const void *context, km_arena *arena); /* NULL when out of memory */
  km_status (*chart)(const void *context, km_chart **out, km_error *error);
  const void *context;
} ksim_delivery;
kt_exit ksim_deliver(const ksim_delivery *delivery);
/* The formats of --format (csv,svg; csv with -o -), and whether they suit -o -, which takes one table and nothing
 * `beside` it. */
kt_exit ksim_read_formats(const kt_common *common, const char *format, const char *base, bool beside,
                          const char *expected, kt_formats *out);

enum { KSIM_AXES_BODY = 2 }; /* the word behind those of km_axes */

/* Options of `ksim run`. */
typedef struct ksim_options {
  kt_common common;
  kt_texts holds, sets, rates, events, stops, frames, forces;
  const char *model, *base, *format, *joints;
  const char *until, *every, *rtol, *atol, *max_step, *from, *limit_stops;
  int integrator, stabilise, axes;
  bool reactions, mobility, animate, ignore_limits;
  kt_formats formats;
} ksim_options;

/* A run, from its options to its files. */
typedef struct ksim_work {
  ksim_options *options;
  kt_pose pose;
  char name[256]; /* name of the model */
  km_history_def def;
  km_crossing *crossings; /* the definition's */
  size_t crossing_capacity;
  int *modules;          /* the definition's */
  km_run_memory *memory; /* the definition's */
  km_history history;
  km_forces *forces;
  int *shown; /* coordinates of --joints, else those that move most */
  int shown_count;
  char stopped_by[KM_ERROR_TEXT]; /* "": it went to the end */
} ksim_work;

/* Sets the crossings of --event and --stop. */
kt_exit ksim_read_crossings(ksim_work *work);
/* Sets the rates of --rate. */
kt_exit ksim_set_rates(ksim_work *work);
/* Names stated initial rates that the motion doesn't start with; KT_PARTIAL where they contradict each other. */
kt_exit ksim_report_rates(const ksim_work *work);

/* Sets the stops of --limit-stops. */
kt_exit ksim_set_limit_stops(const ksim_work *work);
/* The pose, the rates and the time of --from's last row, where it is given. */
kt_exit ksim_continue(ksim_work *work);

/* Joints, rates and energies over time as a plot of `table`, whose columns are those of a history. The caller frees
 * it. */
km_status ksim_chart(const ksim_work *work, const km_table *table, km_chart **out, km_error *error);
/* The modes of linearised equations in motion. */
typedef struct ksim_modes {
  const kt_common *common;
  const char *model, *base; /* the model's file, BASE of the files */
  const kt_pose *pose;
  km_dynamics *dynamics;
  const km_linear *linear;
  int only; /* one line of the modes' table, from 1 on; 0: all */
} ksim_modes;
/* BASE.mode1.html …: by the lines of the table. */
kt_exit ksim_animate_modes(const ksim_modes *modes);
/* BASE.motion.html: the mechanism in motion beside its curves. */
kt_exit ksim_animate(const ksim_work *work, const char *base);

#endif
