/* Commands of kredund. */
#ifndef KREDUND_H
#define KREDUND_H

#include "common/pose.h"
#include "kmech/arm.h"

kt_exit kredund_track(int argc, char **argv);
kt_exit kredund_compare(int argc, char **argv);
kt_exit kredund_selfmotion(int argc, char **argv);
kt_exit kredund_ik(int argc, char **argv);
kt_exit kredund_matrix(int argc, char **argv);
kt_exit kredund_report(int argc, char **argv);

/* Options of the commands about an arm: a study, or a model with equivalent options. */
typedef struct kredund_request {
  kt_common common;
  kt_texts holds, sets;
  const char *study; /* the argument */
  const char *model, *path, *effector, *q, *task, *methods, *objective, *rates;
  const char *branches, *levels, *angle, *stride, *value; /* settings of look-ahead */
  const char *pose;                                       /* ik: x,y,z,rx,ry,rz */
  const char *formats, *base;
  int json;                    /* ik: otherwise a text table */
  const km_assignment *values; /* report: [value_count] other numbers of the model */
  int value_count;
  bool animate;       /* track: a page that plays the motion */
  bool everything;    /* true: without methods, all of them are run */
  bool ignore_limits; /* selfmotion: rows outside the limits too */
} kredund_request;

/* The options of the arm and the path; those of the methods. */
void kredund_arm_options(kt_options *out, kredund_request *request);
void kredund_method_options(kt_options *out, kredund_request *request);

/* A study on its model, at its pose. */
typedef struct kredund_open {
  kt_pose pose;
  km_study_def def;
  km_study *study;
  km_arena arena;       /* memory of the options' values in the definition */
  const char *name;     /* file of the study or model, for messages */
  const char *folder;   /* folder of the study's file */
  char model[4096];     /* its model's file, */
  char model_name[256]; /* and that without folder and ending, for pictures */
  char base[256];       /* base name of output files, by default */
} kredund_open;

/* Reads the study (or makes one from the options), its model, and binds them. `needs_path`: false for commands that can
 * do with the arm's own pose. Says what is wrong. The caller closes it in any case. */
kt_exit kredund_bind(const kredund_request *request, bool needs_path, kredund_open *out);
void kredund_close(kredund_open *open);
/* Start of the study's arm: q[coordinates of the arm], which the caller frees (km_free). NULL, with the error
 * reported, otherwise. */
double *kredund_start(const kredund_request *request, const kredund_open *open, kt_exit *exit);

/* Marks the parts of the definition that options say, so that those of the study's file don't count. */
void kredund_claim_parts(const kredund_request *request, km_study_def *def);
/* Enters the options into the definition. Errors are reported, or added to `messages` with their location. */
kt_exit kredund_set_parts(const kredund_request *request, kredund_open *open, km_messages *messages);
kt_exit kredund_set_methods(const kredund_request *request, kredund_open *open, km_messages *messages);
/* An error at a place; the exit that it means. */
kt_exit kredund_fault(km_messages *messages, bool option, const char *place, const km_error *error);

#endif
