/* Forms of the answer of kspace turning. */
#ifndef KSPACE_TURNING_ANSWER_H
#define KSPACE_TURNING_ANSWER_H

#include "common/pose.h"

#include "kmech/data.h"
#include "kmech/space.h"

void kspace_print_turning(const km_model *model, const km_turning_def *def, const km_turning *turning, km_text *out);
/* NULL: out of memory. */
const km_value *kspace_turning_record(const kt_pose *pose, const km_turning_def *def, const km_turning *turning,
                                      km_arena *arena);

#endif
