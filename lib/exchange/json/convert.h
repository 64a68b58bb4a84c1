/* Writing a checked model back. */
#ifndef KM_EXCHANGE_JSON_CONVERT_H
#define KM_EXCHANGE_JSON_CONVERT_H

#include "base/value.h"
#include "model/model.h"

/* The model as a tree in other units, version 1.0, with the given initial displacements (q[coordinate] in the
 * model's own units; NULL keeps the file's). Everything that was read is kept, left-out elements too. The tree and its
 * text live in `arena`. KM_MEMORY only. */
km_status km_model_convert(const km_model *model, const km_units *units, const double *q, km_arena *arena,
                           const km_value **out, km_error *error);

#endif
