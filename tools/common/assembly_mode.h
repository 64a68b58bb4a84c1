/* Selection of an assembly mode. Private to tools/common: tools use kt_move_to_request. */
#ifndef KT_COMMON_ASSEMBLY_MODE_H
#define KT_COMMON_ASSEMBLY_MODE_H

#include "common/pose.h"

/* Brings a pose to the mode common->mode. Says what went wrong. */
kt_exit kt_mode_take(const kt_common *common, const char *path, const kt_texts *sets, const kt_pose *pose);

#endif
