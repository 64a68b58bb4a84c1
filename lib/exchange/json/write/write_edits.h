/* Numbers that calls have changed, put into the tree of the file that the model was read from. */
#ifndef KM_EXCHANGE_JSON_WRITE_WRITE_EDITS_H
#define KM_EXCHANGE_JSON_WRITE_WRITE_EDITS_H

#include "base/value.h"
#include "model/model.h"

/* The model with the numbers of its file, as a view of the changed one (km_model_keep_unedited). */
km_model km_edits_undone(const km_model *model);
/* True if frames of drawn joints have moved such that points of the drawing can't define them. */
bool km_edits_break_drawing(const km_model *model);
/* Enters changed numbers into the tree, which is in `units`; `drawn`: joints of drawings are defined by points in
 * it. KM_USAGE: a change that no file can state: of a body's own frame, of a part of a strut, or of the mass of a
 * body with a density; KM_MEMORY. O(elements · names). */
km_status km_edits_write(const km_model *model, const km_units *units, bool drawn, km_arena *arena, km_value *root,
                         km_error *error);

#endif
