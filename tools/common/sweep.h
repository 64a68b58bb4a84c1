/* Sweep commands: options, parallel sweeps of several models, files. */
#ifndef KT_SWEEP_H
#define KT_SWEEP_H

#include "common/command_line/question_options.h"
#include "common/command_line/vary.h"
#include "common/pose.h"
#include "common/report_head.h"

#include "kmech/report.h"

enum { KT_MOST_MODELS = 64, KT_JOB_NAME = 1024 };

typedef struct kt_sweep_job kt_sweep_job;

/* Options of sweep and report commands. */
typedef struct kt_sweep_options {
  kt_common common;
  kt_question asked; /* the question */
  kt_texts holds, sets, models, vary;
  kt_variants variants; /* variants of `vary`, set by kt_sweep */
  const char *joints;   /* --joints: coordinates whose curves are drawn, or NULL */
  const char *base;     /* -o, or NULL */
  const char *format;   /* --format, or NULL */
  kt_formats formats;   /* formats of --format, set by kt_sweep */
  kt_report_head head;  /* head of a report */
  const char *over;     /* quantity across a report's curves; NULL: the driver or the time */
  char followed[512];   /* "body/frame" of `over` */
  /* Kinds without a sweep: says what a result with rows calls for; returns the exit code of the result. */
  kt_exit (*tell)(kt_sweep_job *job);
  /* Writes what all jobs gave, instead of tables and plots; NULL: those. */
  kt_exit (*deliver)(struct kt_sweep_options *options, const kt_sweep_job *jobs, int count);
  /* Writes more files of a job, named after `base`; NULL: none. */
  kt_exit (*write_more)(const kt_sweep_job *job, const char *base);
} kt_sweep_options;

/* The options of a kind of question, --hold and --set. */
void kt_sweep_options_add(kt_options *out, kt_sweep_options *options, const char *kind);
/* These, --format, --base and the common ones of a command for several models. */
void kt_sweep_options_several(kt_options *out, kt_sweep_options *options, const char *kind, const char *base_help);
#define KT_SWEEP_BASE(RESULT) "Files are BASE." RESULT ".FORMAT (default: the model's name); - is the standard output"

/* One model of the sweep, or one variant of one, with all that its files are made of. */
struct kt_sweep_job {
  const kt_sweep_options *options;
  kt_common common; /* context with its own log */
  km_text log;
  const char *path;
  int variant; /* index in options->variants */
  km_assignment values[KT_MOST_VARIED];
  char variant_name[KT_VARIANT_NAME]; /* "rise=40"; "" */
  char name[KT_JOB_NAME];             /* name in messages and summaries: the path and the variant */
  char label[KT_JOB_NAME];            /* name at curves: of the model or the variant */
  char base[KT_JOB_NAME];             /* name in file names: without blanks and slashes */
  kt_pose pose;
  km_question *question;
  int *shown; /* [shown_count] coordinates of --joints; NULL: not given */
  int shown_count;
  km_text stopped_by;
  kt_exit result;
  bool empty; /* no pose of the range is in reach: there is nothing to write */
};

/* Computes the question for all models and variants on --jobs threads, and writes the requested files. */
kt_exit kt_sweep(kt_sweep_options *options);

/* Computes the question for all models and variants, and delivers what they give; kt_sweep without its formats. */
kt_exit kt_sweep_all(kt_sweep_options *options);
/* Takes the values of its variant, and names it after these and its model: name, label, base. */
void kt_sweep_job_name(kt_sweep_job *job);
/* Reads the model of a job that has its names and brings it to its pose; job->result says how it went. `metres`:
 * another model's characteristic length, 0: its own. */
void kt_sweep_job_open(kt_sweep_job *job, double metres);
/* Computes the question of a job whose model is open; job->result is its exit code. */
void kt_sweep_job_run(kt_sweep_job *job);
/* BASE: what -o says, else the first model's name, with `-compared` behind it where there are several or variants. */
void kt_sweep_base(const kt_sweep_options *options, char *out, size_t size);
/* True if there is something to write. */
bool kt_sweep_job_delivers(const kt_sweep_job *job);
void kt_sweep_job_close(kt_sweep_job *job);

#endif
