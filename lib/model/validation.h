/* What every way to make a model shares: labels, and checks that need all its elements. */
#ifndef KM_MODEL_VALIDATION_H
#define KM_MODEL_VALIDATION_H

#include "base/name_map.h"
#include "model/model.h"

/* Scopes of the labels. Faulty: names of joints that an error was reported for; what names them is not judged. */
enum { KM_LABEL_JOINT, KM_LABEL_COORDINATE, KM_LABEL_COUNT, KM_LABEL_FAULTY, KM_LABEL_LEFT_OUT, KM_LABEL_TAKEN };

/* A joint's label is its name where no other joint has that name or label, else its full path; coordinate k of several
 * is `label[k]`. Enters all of them in the table. Reports two joints of one label. */
void km_model_assign_labels(km_model *model, km_names *labels, km_messages *messages);
/* Reports every body that no chain of joints ties to the inertial frame. */
void km_model_check_ties(km_model *model, km_messages *messages);
/* Reports negative principal moments, and notes moments that no body has. After every body and frame is there: their size tells what rounding is. */
void km_model_check_inertias(const km_model *model, km_messages *messages);
/* "mesh", "box" …, as our format and those of robots call a kind of shape. */
const char *km_shape_word(km_shape_kind kind);
/* How many sizes a kind of shape has. */
int km_shape_sizes(km_shape_kind kind);
/* The rotation nearest to a matrix M by its rows, where no entry of M is more than KM_ROTATION_ROUNDING off. `misfit` is the
 * largest entry of MᵀM − I. KM_MODEL, and the identity, for what is no rotation. */
#define KM_ROTATION_ROUNDING 1e-2 /* what is further off is another mistake than rounding to two digits */
km_status km_model_rotation(const double rows[9], km_rotation *out, double *misfit, km_error *error);

#endif
