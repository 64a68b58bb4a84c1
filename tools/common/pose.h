/* A model at a pose, and the options of the commands about one. */
#ifndef KT_POSE_H
#define KT_POSE_H

#include "common/common.h"
#include "kmech/mechanism.h"

/* A model at a pose. */
typedef struct kt_pose {
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
} kt_pose;

/* Reads a model and brings it to the configuration of its analysis.hold, --hold, --set and --mode. Reports errors.
 * The caller closes the pose in any case. */
kt_exit kt_open(const kt_common *common, const char *path, const kt_texts *holds, const kt_texts *sets, kt_pose *out);
/* Opens a model whose numbers are replaced by `values`[count] in the same way. */
kt_exit kt_open_varied(const kt_common *common, const char *path, const km_assignment *values, int count,
                       const kt_texts *holds, const kt_texts *sets, kt_pose *out);
/* Brings a model that was read, out->model, to the configuration; mechanism and state must be NULL. */
kt_exit kt_move_to_request(const kt_common *common, const char *path, const kt_texts *holds, const kt_texts *sets,
                           kt_pose *out);
void kt_close(kt_pose *pose);

/* The assembly modes at a pose. The driver is the first joint of --set, else that of analysis.sweep. KM_USAGE: there is
 * none. Free `*modes` in any case. */
km_status kt_modes_find(const kt_common *common, const kt_texts *sets, const kt_pose *pose, int *driver,
                        km_modes *modes, km_error *error);

/* --set and --hold, where the commands say of it: KT_SET_FROM: where the motion starts. */
#define KT_SET(TARGET, HELP)                                                                                           \
  { "set", 0, "JOINT=VALUE", HELP, KT_TEXTS, TARGET, KT_ABOUT_MODEL }
#define KT_HOLD(TARGET, HELP)                                                                                          \
  { "hold", 0, "JOINT=VALUE", HELP, KT_TEXTS, TARGET, KT_ABOUT_MODEL }
#define KT_MODE(COMMON)                                                                                                \
  {                                                                                                                    \
    "mode", 0, "K", "Take assembly mode K, as kmob info --modes numbers them", KT_COUNT, &(COMMON).mode,               \
        KT_ABOUT_MODEL                                                                                                 \
  }
#define KT_POSE(COMMON)                                                                                                \
  {                                                                                                                    \
    "pose", 0, "NAME", "Start from this one of the poses that the model names", KT_TEXT, &(COMMON).pose,               \
        KT_ABOUT_MODEL                                                                                                 \
  }
#define KT_BASE(TARGET, HELP)                                                                                          \
  { "base", 'o', "BASE", HELP, KT_BEGIN, TARGET, KT_ABOUT_FILES }
#define KT_SET_FIRST  "Start from another pose: move a joint to a value first"
#define KT_HOLD_RIGID "Keep a joint rigid at a value (x,y,… for several coordinates)"

/* Options of the commands about one configuration. */
typedef struct kt_request {
  kt_common common;
  kt_texts holds, sets;
  const char *model;
  const char *base; /* -o, or NULL */
  int json;         /* otherwise a text table */
} kt_request;

/* --hold --format --base and the model, --set too where it is `settable`. RESULT is the word in the files' names. */
#define KT_REQUEST_BASE(RESULT) "Write BASE." RESULT ".txt or .json instead of the standard output"
void kt_request_options(kt_options *out, kt_request *request, bool settable, const char *base_help);

/* The requested configuration. */
kt_exit kt_request_open(const kt_request *request, kt_pose *out);
/* Writes BASE.RESULT.txt or .json, or to the standard output without -o. */
kt_exit kt_answer(const kt_request *request, const char *result, const km_text *text);

#endif
