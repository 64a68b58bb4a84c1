/* Answers as pictures. */
#ifndef KMECH_PICTURES_H
#define KMECH_PICTURES_H

#include "kmech/bytes.h"
#include "kmech/path_study.h"
#include "kmech/question.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum km_picture_format { KM_PICTURE_SVG, KM_PICTURE_PDF, KM_PICTURE_PNG } km_picture_format;

/* The plot of a question's last answer. `name` is that of the model, for people. The caller frees `*out`. KM_USAGE: it has
 * no answer, or something is missing; KM_MEMORY. O(rows). */
KM_API km_status km_question_picture(const km_question *question, const char *name, km_picture_format format,
                                     km_bytes *out, km_error *error);
/* The plots of a track: joints, path-control entries and objectives over the path. The caller frees `*out`. KM_USAGE,
 * KM_MEMORY. O(samples). */
KM_API km_status km_track_picture(const km_study *study, km_track *track, const char *name, km_picture_format format,
                                  km_bytes *out, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
