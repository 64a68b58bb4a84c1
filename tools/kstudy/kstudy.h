/* kstudy's commands, and what they share: the study of the command line with its store. */
#ifndef KSTUDY_H
#define KSTUDY_H

#include "common/pose.h"
#include "kmech/report.h"
#include "kmech/study.h"

/* Context of every command. */
typedef struct kstudy_request {
  kt_common common;
  const char *study;
  const char *store; /* --store, or NULL */
  const char *base;  /* -o, or NULL */
  const char *format;
} kstudy_request;

/* STUDY, --store, -o and the common options. */
void kstudy_options(kt_options *out, kstudy_request *request, unsigned uses);

typedef struct kstudy_open {
  km_arena arena;
  km_design_study_def def;
  km_design_sample sample; /* table of its CSV file */
  km_design_study *study;
  const char *name;  /* name in messages */
  char model[4096];  /* the model's file, seen from here */
  char folder[4096]; /* folder of the study */
  char base[4096];   /* base of file names */
  char store[4096 + 16];
} kstudy_open;

/* Reads the study, and opens its store. `must_exist`: a store that isn't there is an error. Says what is wrong.
 * Close in any case. */
kt_exit kstudy_compile(const kstudy_request *request, bool must_exist, kstudy_open *out);
void kstudy_close(kstudy_open *open);

/* Lengths of a name as part of a file name, and of the part after BASE. */
enum { KSTUDY_WORD = 200, KSTUDY_NAME = 400 };

/* Reports an error if two pictures would have the same file. */
kt_exit kstudy_check_names(const kstudy_request *request, kstudy_open *open);
/* Pictures of what the study came to, in the formats of the list. */
kt_exit kstudy_plot(const kstudy_request *request, kstudy_open *open, const kt_formats *formats);
/* Writes `file`, or where it is NULL BASE.study-report.html or .pdf. `header` may be NULL. */
kt_exit kstudy_write_report(const kstudy_request *request, kstudy_open *open, const km_report_header *header,
                            const char *file, bool html);
/* The tables and statistics, on the standard output. */
kt_exit kstudy_print(const kstudy_request *request, kstudy_open *open);
/* A figure's name as a part of a file's name. */
void kstudy_word(const char *figure, char *out, size_t size);
/* The models of the best design, or of the worst cases of a sample, as files. */
kt_exit kstudy_write_models(const kstudy_request *request, kstudy_open *open);

kt_exit kstudy_run(int argc, char **argv);
kt_exit kstudy_resume(int argc, char **argv);
kt_exit kstudy_show(int argc, char **argv);
kt_exit kstudy_report(int argc, char **argv);
kt_exit kstudy_export(int argc, char **argv);
kt_exit kstudy_plan(int argc, char **argv);

#endif
