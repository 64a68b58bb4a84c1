/* Writing a checked model back. */
#ifndef KM_EXCHANGE_JSON_CONVERT_H
#define KM_EXCHANGE_JSON_CONVERT_H

#include "base/value.h"
#include "model/model.h"

/* The model as a tree in other units, version 1.0 or newer as the file, with the given initial displacements
 * (q[coordinate] in the model's own units; NULL keeps the file's). Everything that was read is kept, left-out elements
 * too. A drawing stays one where the pose is the drawn one; for another pose, or where `frames` asks for it, it is
 * written as frames of the bodies. Expressions and parameters stay where both the units and the drawing do, else they
 * become numbers. The tree and its text live in `arena`. KM_MEMORY only. */
km_status km_model_convert(const km_model *model, const km_units *units, const double *q, bool frames, km_arena *arena,
                           const km_value **out, km_error *error);
/* Does the model's file name numbers by parameters? */
bool km_model_has_parameters(const km_model *model);

#endif
