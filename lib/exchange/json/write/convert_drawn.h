/* Writing what an assembly draws by points as frames of its bodies, for a pose that isn't the drawn one. */
#ifndef KM_EXCHANGE_JSON_WRITE_CONVERT_DRAWN_H
#define KM_EXCHANGE_JSON_WRITE_CONVERT_DRAWN_H

#include "base/value.h"
#include "model/model.h"

/* True if a joint of a drawn assembly differs from its drawn value; q[coordinate] in the model's units. */
bool km_drawing_moved(const km_model *model, const double *q);
/* True if the joint belongs to a drawn assembly. */
bool km_joint_in_drawing(const km_model *model, int joint);
/* Adds the frames that drawn joints made on a body to `frames` of its object; lengths times `factor`. */
void km_write_drawn_frames(const km_model *model, int body, double factor, km_arena *arena, km_value *object);
/* Adds the `body_frame_pairs` of a drawn joint. */
void km_write_drawn_pair(const km_model *model, int joint, km_arena *arena, km_value *object);

#endif
