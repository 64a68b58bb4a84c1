/* Models that no JSON text was read for: the text that says the same. */
#ifndef KM_EXCHANGE_JSON_WRITE_WRITE_BUILT_H
#define KM_EXCHANGE_JSON_WRITE_WRITE_BUILT_H

#include "base/name_map.h"
#include "base/value.h"
#include "model/model.h"

/* The model as a tree in the model format, in its own units; its joints' first values are its own. Meshes, force
 * laws of joints, frames, couplings and actuators are in it; what only JSON files can state isn't. */
const km_value *km_built_tree(const km_model *model, km_arena *arena);
/* km_model_convert of such a model. */
km_status km_built_convert(const km_model *model, const km_units *units, const double *q, bool frames, km_arena *arena,
                           const km_value **out, km_error *error);

#endif
