/* Numbers that calls have changed, put into the tree of the file that the model was read from. */
#ifndef KM_EXCHANGE_JSON_WRITE_WRITE_EDITS_H
#define KM_EXCHANGE_JSON_WRITE_WRITE_EDITS_H

#include "base/value.h"
#include "model/model.h"

/* The model with the numbers of its file, as a view of the changed one (km_model_keep_unedited). */
km_model km_edits_undone(const km_model *model);
/* Are frames of drawn joints moved so that points of the drawing can't tell them? */
bool km_edits_break_drawing(const km_model *model);
/* Puts what differs into the tree, which is written in `units`; `drawn`: joints of drawings are told by points in
 * it. KM_USAGE: a body's own frame was moved, or a part of a strut, or the mass of a body that is weighed by a
 * density, which no file says; KM_MEMORY. O(elements · names). */
km_status km_edits_write(const km_model *model, const km_units *units, bool drawn, km_arena *arena, km_value *root,
                         km_error *error);

#endif
