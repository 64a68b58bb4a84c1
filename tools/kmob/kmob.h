/* What kmob's commands share. */
#ifndef KMOB_H
#define KMOB_H

#include "common/common.h"
#include "kmech/mobility_sweep.h"

kt_exit kmob_info(int argc, char **argv);
kt_exit kmob_at(int argc, char **argv);
kt_exit kmob_sweep(int argc, char **argv);
kt_exit kmob_graph(int argc, char **argv);
kt_exit kmob_check(int argc, char **argv);
kt_exit kmob_draw(int argc, char **argv);
kt_exit kmob_convert(int argc, char **argv);
kt_exit kmob_new(int argc, char **argv);
kt_exit kmob_schema(int argc, char **argv);

enum { KMOB_MOST_TEXTS = 256 };

/* Repeated options as they were given. */
typedef struct kmob_texts {
  char *items[KMOB_MOST_TEXTS];
  int count;
} kmob_texts;
void kmob_texts_add(kmob_texts *texts, char *text, struct argp_state *state);

/* A model at a pose. */
typedef struct kmob_pose {
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
} kmob_pose;

/* What the commands about one pose (info, at, check) are asked. */
typedef struct kmob_request {
  kt_common common;
  kmob_texts holds, sets;
  const char *model, *base;
  bool json;  /* else a table for people */
  bool modes; /* list the other assembly modes too */
} kmob_request;

/* Reads the options of such a command; usage errors end the process. `settable`: it takes --set. */
kmob_request kmob_read_request(int argc, char **argv, const char *about, bool settable);
/* Writes BASE.RESULT.txt or .json, or to the standard output without -o. */
kt_exit kmob_answer(const kmob_request *request, const char *result, const km_text *text);

/* Loads a model and brings it to the pose that its analysis.hold, --hold and --set ask for. Says what went
 * wrong. The caller closes the pose in any case. */
kt_exit kmob_open(const kt_common *common, const char *path, const kmob_texts *holds, const kmob_texts *sets,
                  kmob_pose *out);
/* The same for a model that is loaded, out->model; mechanism and state must be NULL. */
kt_exit kmob_bring(const kt_common *common, const char *path, const kmob_texts *holds, const kmob_texts *sets,
                   kmob_pose *out);
void kmob_close(kmob_pose *pose);

#endif
