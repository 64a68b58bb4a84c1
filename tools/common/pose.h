/* A model at a pose, and the options of the commands about one. */
#ifndef KT_POSE_H
#define KT_POSE_H

#include "common/common.h"

enum { KT_MOST_TEXTS = 256 };

/* Repeated options as they were given. */
typedef struct kt_texts {
  char *items[KT_MOST_TEXTS];
  int count;
} kt_texts;
void kt_texts_add(kt_texts *texts, char *text, struct argp_state *state);

/* A model at a pose. */
typedef struct kt_pose {
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
} kt_pose;

/* Loads a model and brings it to the pose that its analysis.hold, --hold and --set ask for. Says what went
 * wrong. The caller closes the pose in any case. */
kt_exit kt_open(const kt_common *common, const char *path, const kt_texts *holds, const kt_texts *sets, kt_pose *out);
/* The same for a model that is loaded, out->model; mechanism and state must be NULL. */
kt_exit kt_bring(const kt_common *common, const char *path, const kt_texts *holds, const kt_texts *sets, kt_pose *out);
void kt_close(kt_pose *pose);

/* What the commands about one pose are asked: --hold --format and the model; --set too with the second parser.
 * Child parsers whose input is a kt_request; a command's own parser has -o. */
typedef struct kt_request {
  kt_common common;
  kt_texts holds, sets;
  const char *model;
  const char *base; /* of -o, or NULL */
  bool json;        /* else a table for people */
} kt_request;

extern const struct argp kt_request_argp, kt_settable_argp;

/* The pose that the request asks for. */
kt_exit kt_request_open(const kt_request *request, kt_pose *out);
/* Writes BASE.RESULT.txt or .json, or to the standard output without -o. */
kt_exit kt_answer(const kt_request *request, const char *result, const km_text *text);

#endif
