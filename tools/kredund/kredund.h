/* What kredund's commands share. */
#ifndef KREDUND_H
#define KREDUND_H

#include "common/pose.h"
#include "kmech/arm.h"

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
  km_study_def def;
  km_study *study;
  km_arena arena;       /* of what options put into the definition */
  const char *name;     /* of the study or the model, for messages */
  const char *folder;   /* of the study's file */
  char model[4096];     /* its model's file, */
  char model_name[256]; /* and that without folder and ending, for pictures */
  char base[256];       /* of output files, unless they are given another */
} kredund_open;

/* Reads the study (or makes one from the options), its model, and binds them. `needs_path`: false for commands that can
 * do with the arm's own pose. Says what is wrong. The caller closes it in any case. */
kt_exit kredund_bring(const kredund_request *request, bool needs_path, kredund_open *out);
void kredund_close(kredund_open *open);
/* Where the study's arm starts: q[coordinates of the arm], which the caller frees (km_free). NULL, said, with the exit
 * otherwise. */
double *kredund_start(const kredund_request *request, const kredund_open *open, kt_exit *exit);

/* Marks the parts of the definition that options say, so that those of the study's file don't count. */
void kredund_claim_parts(const kredund_request *request, km_study_def *def);
/* Puts what the options say into the definition. What is wrong is told, or goes to `messages` with its place. */
kt_exit kredund_set_parts(const kredund_request *request, kredund_open *open, km_messages *messages);
kt_exit kredund_set_methods(const kredund_request *request, kredund_open *open, km_messages *messages);
/* An error at a place; the exit that it means. */
kt_exit kredund_fault(km_messages *messages, bool option, const char *place, const km_error *error);

#endif
