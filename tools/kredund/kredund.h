/* What kredund's commands share. */
#ifndef KREDUND_H
#define KREDUND_H

#include "arm/study.h"
#include "common/pose.h"

kt_exit kredund_track(int argc, char **argv);
kt_exit kredund_compare(int argc, char **argv);
kt_exit kredund_selfmotion(int argc, char **argv);
kt_exit kredund_ik(int argc, char **argv);
kt_exit kredund_matrix(int argc, char **argv);

/* What the commands about an arm are asked: a study, or a model with options that say the same. */
typedef struct kredund_request {
  kt_common common;
  kt_texts holds, sets;
  const char *study; /* the argument */
  const char *model, *path, *effector, *q, *task, *methods, *objective, *rates;
  const char *branches, *levels, *angle, *stride, *value; /* of look-ahead */
  const char *pose;                                       /* ik: x,y,z,rx,ry,rz */
  const char *formats, *base;
  int json;           /* ik: else a table for people */
  bool everything;    /* without methods: all of them */
  bool ignore_limits; /* selfmotion: rows outside the limits too */
} kredund_request;

/* The options of the arm and the path; those of the methods. */
void kredund_arm_options(kt_options *out, kredund_request *request);
void kredund_method_options(kt_options *out, kredund_request *request);

/* A study on its model, at its pose. */
typedef struct kredund_open {
  kt_pose pose;
  km_study *study;
  km_arena arena;
  const char *name;     /* of the study or the model, for messages */
  char model[4096];     /* its file, */
  char model_name[256]; /* and that without folder and ending, for pictures */
  char base[256];       /* of output files, unless they are given another */
} kredund_open;

/* Reads the study (or makes one from the options), its model, and binds them. `needs_path`: false for commands that can
 * do with the arm's own pose. Says what is wrong. The caller closes it in any case. */
kt_exit kredund_bring(const kredund_request *request, bool needs_path, kredund_open *out);
void kredund_close(kredund_open *open);

/* Options as a study's values, in the open study's arena: numbers or names a,b,…; NAME or NAME=WEIGHT,…; the methods
 * with the settings of options in the place of their own, NULL: the study's as they are. `exit` tells what is wrong,
 * told. */
const km_value *kredund_as_list(kredund_open *open, const char *text, bool numbers, const kt_common *common,
                                const char *option, kt_exit *exit);
const km_value *kredund_as_objective(kredund_open *open, const char *text, const kt_common *common, kt_exit *exit);
const km_value *kredund_as_methods(kredund_open *open, const kredund_request *request, kt_exit *exit);

#endif
