/* Validation of path plans that needs no arm, with the location of a fault. */
#ifndef KM_MODEL_PATH_STUDY_PATH_PLAN_H
#define KM_MODEL_PATH_STUDY_PATH_PLAN_H

#include "kmech/arm.h"

/* Location in a plan: segments[segment].key[item], or a key of the plan. */
typedef struct km_path_fault {
  int segment;     /* −1: the plan */
  const char *key; /* NULL: the segment */
  int item;        /* −1: all items */
} km_path_fault;
#define KM_PATH_NO_FAULT ((km_path_fault){-1, "segments", -1})

enum { KM_PATH_FAULT_TEXT = 64 };
/* Writes a location as text: "segments", "segments[2].points[1]". Returns `out`. */
const char *km_path_fault_text(const km_path_fault *fault, char out[KM_PATH_FAULT_TEXT]);

/* Checks a plan. KM_USAGE: speeds, counts, directions or waves are out of range; `fault` is the location. */
km_status km_path_plan_check(const km_path_plan *plan, km_path_fault *fault, km_error *error);

#endif
