/* Path studies: a model, an effector, a path, a start and methods in one file. */
#ifndef KMECH_PATH_STUDY_H
#define KMECH_PATH_STUDY_H

#include "kmech/track.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct km_study km_study;

/* Reads a study from `size` bytes of JSON; `folder` is that of the file ("" the current one). Findings go to `messages`
 * with their place; with any error the status is KM_MODEL and `*out` is NULL. The caller frees `*out`. */
KM_API km_status km_study_read(const char *bytes, size_t size, const char *folder, km_messages *messages,
                               km_study **out, km_error *error);
KM_API void km_study_free(km_study *study);

/* The model's file: as written, seen from the study's folder; NULL if the study names none. Borrowed. */
KM_API const char *km_study_model(const km_study *study);

/* Makes arm, path, start and methods from the study and a mechanism of its model at its pose. The start is the study's
 * q0, or else the state's pose, brought to the path's first pose by inverse kinematics where it isn't there. KM_MODEL,
 * KM_USAGE: something in the study is wrong; KM_NO_RESULT: no start within the limits reaches the first pose. The
 * mechanism must outlive the study. */
KM_API km_status km_study_bind(km_study *study, const km_mechanism *mechanism, const km_state *state,
                               unsigned long seed, km_messages *messages, km_error *error);

KM_API const km_arm *km_study_arm(const km_study *study);
/* The plan of method i: path, start, method, objective; jobs 1, seed 1. */
KM_API km_track_plan km_study_plan(const km_study *study, int method);
KM_API int km_study_methods(const km_study *study);

#ifdef __cplusplus
}
#endif
#endif
