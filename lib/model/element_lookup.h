/* Suggestions for unknown labels of joints and paths of frames; km_model_find_joint and others are in kmech/model.h. */
#ifndef KM_MODEL_ELEMENT_LOOKUP_H
#define KM_MODEL_ELEMENT_LOOKUP_H

#include "model/model.h"

/* The labels of joints nearest to `wanted`, as text; names while a file is read and labels don't exist. Returns
 * `out`. */
const char *km_nearest_joint_labels(const km_model *model, const char *wanted, char out[KM_NEAREST_TEXT]);
/* The paths body/frame nearest to `wanted`, as text. Returns `out`. */
const char *km_nearest_frame_paths(const km_model *model, const char *wanted, char out[KM_NEAREST_TEXT]);

#endif
