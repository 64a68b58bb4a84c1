/* What the sweep commands of the tools share: options, models swept at once, files. */
#ifndef KT_SWEEP_H
#define KT_SWEEP_H

#include "common/pose.h"
#include "kmech/sweep_plan.h"

enum { KT_MOST_MODELS = 64, KT_MOST_POINTS = 64 };

/* What sweep and report commands are asked. */
typedef struct kt_sweep_options {
  kt_common common;
  kt_texts holds, sets, points, models;
  const char *joint, *range, *steps, *arclength, *direction, *branch;
  const char *base;   /* of -o, or NULL */
  const char *format; /* of --format, or NULL */
  kt_formats formats; /* what it says. By kt_sweep */
  bool derivatives, ignore_limits, cycle;
  const void *own; /* the command's own options */
} kt_sweep_options;

/* --joint --range --steps --arclength --direction --cycle --branch --hold --set --ignore-limits --derivatives. */
void kt_sweep_options_add(kt_options *out, kt_sweep_options *options);
/* These, --format, --base and the common ones of a command for several models. */
void kt_sweep_options_several(kt_options *out, kt_sweep_options *options, const char *base_help);
#define KT_SWEEP_BASE(RESULT) "Files are BASE." RESULT ".FORMAT (default: the model's name); - is the standard output"
#define KT_PATH_POINT(TARGET)                                                                                          \
  { "point", 0, "BODY/FRAME", "Add the path of a frame's origin (repeatable)", KT_TEXTS, TARGET, KT_ABOUT_MODEL }

/* One model of the sweep, with all that its files are made of. */
typedef struct kt_sweep_job {
  const kt_sweep_options *options;
  kt_common common; /* with a log of its own */
  km_text log;
  const char *path;
  char base[256];
  kt_pose pose;
  km_sweep_plan plan;
  km_sweep_point points[KT_MOST_POINTS];
  char *names[KT_MOST_POINTS]; /* of the points, owned */
  km_text stopped_by;
  kt_exit result;
  bool empty; /* no pose of the range is in reach: there is nothing to write */
  void *own;  /* what the command makes of it */
} kt_sweep_job;

/* A sweep command: what to do with one model, and with all of them. */
typedef struct kt_sweeping {
  const char *word; /* of the result, as in BASE.WORD.csv */
  /* Prepares `own` from the options, at the pose; says what is wrong. May be NULL. */
  kt_exit (*prepare)(kt_sweep_job *job);
  /* Runs the sweep into `own`; *motion is its rows. */
  km_status (*run)(kt_sweep_job *job, const km_sweep **motion, km_error *error);
  void (*print)(const kt_sweep_job *job, km_text *out); /* a summary */
  const km_table *(*table)(const kt_sweep_job *job);
  km_value *(*record)(const kt_sweep_job *job, km_arena *arena);
  /* One plot for all the models that were swept. */
  km_status (*plot)(const kt_sweep_job *const *jobs, int count, km_canvas_format format, km_text *out, km_error *error);
  void (*free)(kt_sweep_job *job);
} kt_sweeping;

/* Sweeps every model, --jobs at once, and writes what was asked for. */
kt_exit kt_sweep(kt_sweep_options *options, const kt_sweeping *sweeping);

/* Reads the job's model and brings it to its pose; job->result says how it went. `metres`: another model's
 * characteristic length, 0: its own. */
void kt_sweep_job_open(kt_sweep_job *job, double metres);
/* Frees what a job holds beside `own`. */
void kt_sweep_job_close(kt_sweep_job *job);
/* Makes the plan of a job whose model is open and runs the sweep; job->result says how it went. `prepare` may be
 * NULL. */
void kt_sweep_job_run(kt_sweep_job *job, kt_exit (*prepare)(kt_sweep_job *job),
                      km_status (*run)(kt_sweep_job *job, const km_sweep **motion, km_error *error));

/* Reads the plan of a model from the options over the model's own. Says what is wrong. */
kt_exit kt_sweep_plan(kt_sweep_job *job);

#endif
