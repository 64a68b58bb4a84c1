/* Labels and validation of a complete model, shared by the builder and the JSON reader. */
#ifndef KM_MODEL_VALIDATION_H
#define KM_MODEL_VALIDATION_H

#include "base/name_map.h"
#include "model/model.h"

/* Scopes of labels. Faulty: names of joints with reported errors; references to them aren't reported again. */
enum { KM_LABEL_JOINT, KM_LABEL_COORDINATE, KM_LABEL_COUNT, KM_LABEL_FAULTY, KM_LABEL_LEFT_OUT, KM_LABEL_TAKEN };

/* Enters the labels of all joints in the table: the name if no other joint has that name or label, otherwise the
 * full path; coordinate k of several is `label[k]`. Reports duplicate labels. */
void km_model_assign_labels(km_model *model, km_names *labels, km_messages *messages);
/* Reports each body that no chain of joints connects to the inertial frame. */
void km_model_check_ties(km_model *model, km_messages *messages);
/* Reports negative principal moments, and moments that violate the triangle inequality. Needs all bodies and frames,
 * whose size determines the rounding tolerance. */
void km_model_check_inertias(const km_model *model, km_messages *messages);
/* Names of the kinds of shapes in the formats: "mesh", "box" … */
const char *km_shape_word(km_shape_kind kind);
/* Number of sizes of a kind of shape. */
int km_shape_sizes(km_shape_kind kind);
/* Finds the rotation nearest to a matrix M (by rows), if no entry of M differs by more than KM_ROTATION_ROUNDING.
 * `misfit`: largest entry of MᵀM − I. Otherwise KM_MODEL and the identity. */
#define KM_ROTATION_ROUNDING 1e-2 /* a larger difference isn't rounding to two digits */
km_status km_model_rotation(const double rows[9], km_rotation *out, double *misfit, km_error *error);

#endif
