/* The path that an effector is to follow. */
#ifndef KMECH_PATH_H
#define KMECH_PATH_H

#include "kmech/arm.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct km_path km_path;

KM_API void km_path_free(km_path *path);
KM_API int km_path_samples(const km_path *path);
/* The metric s up to a sample, model's unit: ds² = |dp|² + L²dθ² (theory 6); the length that the effector's origin has
 * travelled, and the angle in radians by which the effector has turned, as far as the task counts it; time in seconds;
 * the pose. */
KM_API double km_path_length(const km_path *path, int sample);
KM_API double km_path_travel(const km_path *path, int sample);
KM_API double km_path_turn(const km_path *path, int sample);
KM_API double km_path_time(const km_path *path, int sample);
KM_API void km_path_pose(const km_path *path, int sample, km_frame_pose *pose);

#ifdef __cplusplus
}
#endif
#endif
