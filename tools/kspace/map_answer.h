/* Forms of the answer of kspace map. */
#ifndef KSPACE_MAP_ANSWER_H
#define KSPACE_MAP_ANSWER_H

#include "common/pose.h"

#include "kmech/data.h"
#include "kmech/space.h"

void kspace_print_map(const kt_pose *pose, const char *file, const km_space_map_def *def, const km_all_modes *modes,
                      const km_space_map *map, km_text *out);
/* NULL: out of memory. */
const km_value *kspace_map_record(const kt_pose *pose, const char *file, const km_space_map_def *def,
                                  const km_all_modes *modes, const km_space_map *map, km_arena *arena);

#endif
