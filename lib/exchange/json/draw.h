/* Writing a model as drawings: all bodies in one pose, joints by points and axes. */
#ifndef KM_EXCHANGE_JSON_DRAW_H
#define KM_EXCHANGE_JSON_DRAW_H

#include "base/value.h"
#include "model/model.h"

/* The model as a tree whose assemblies are `drawn` in the pose q[coordinate] (in the model's own units; NULL: the file's
 * first values), in other units: the frames, centres of mass and inertias of their bodies stand where the inertial frame
 * sees them, and joints are told by `bodies`, `at` and `axis` where that says all. A joint whose coordinates need whole
 * frames (ball, float, universal and planar joints that are turned) keeps its pair of frames. Frames that only such
 * joints named are left out. An assembly that can't be drawn keeps its frames, with a note in `notes` (may be NULL).
 * Expressions become numbers, struts stay struts. Points are rounded to 1e-14 of the largest coordinate. The tree and
 * its text live in `arena`. A model that is drawn in this pose already is written as by
 * km_model_convert, expressions and all. KM_NO_RESULT: no assembly can be drawn; KM_MEMORY. */
km_status km_model_draw(const km_model *model, const km_units *units, const double *q, km_messages *notes,
                        km_arena *arena, const km_value **out, km_error *error);

#endif
