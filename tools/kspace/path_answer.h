/* Forms of the answer of kspace path. */
#ifndef KSPACE_PATH_ANSWER_H
#define KSPACE_PATH_ANSWER_H

#include "common/pose.h"

#include "kmech/data.h"
#include "kmech/space.h"

typedef struct kspace_path_answer {
  const kt_pose *pose; /* start */
  const char *model;   /* its file */
  int drivers[KM_MAX_PATH_DRIVERS], driver_count;
  bool has_free_end; /* the end states the drivers only: it has any assembly mode */
  double margin;
  km_space_path path;
} kspace_path_answer;

void kspace_print_path(const kspace_path_answer *answer, km_text *out);
/* NULL: out of memory. */
const km_value *kspace_path_record(const kspace_path_answer *answer, km_arena *arena);

#endif
