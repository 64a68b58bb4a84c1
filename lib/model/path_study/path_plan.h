/* Plans of paths: where in one something is wrong, and what is wrong in itself, without an arm. */
#ifndef KM_MODEL_PATH_STUDY_PATH_PLAN_H
#define KM_MODEL_PATH_STUDY_PATH_PLAN_H

#include "kmech/arm.h"

/* A place in a plan: segments[segment].key[item], or a key of the plan itself. */
typedef struct km_path_fault {
  int segment;     /* −1: the plan itself */
  const char *key; /* NULL: the segment itself */
  int item;        /* −1: all of them */
} km_path_fault;
#define KM_PATH_NO_FAULT ((km_path_fault){-1, "segments", -1})

enum { KM_PATH_FAULT_TEXT = 64 };
/* "segments", "segments[2].points[1]". Returns `out`. */
const char *km_path_fault_text(const km_path_fault *fault, char out[KM_PATH_FAULT_TEXT]);

/* KM_USAGE: speeds, counts, directions or waves are out of range; `fault` says where. */
km_status km_path_plan_check(const km_path_plan *plan, km_path_fault *fault, km_error *error);

#endif
