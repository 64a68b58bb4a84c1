/* Singular configurations of a mobility sweep as record and as text. */
#ifndef KM_REPORT_RECORD_SINGULAR_VALUE_RECORD_H
#define KM_REPORT_RECORD_SINGULAR_VALUE_RECORD_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/sweep.h"

/* Adds `singularities` [{s, kind, joints | mobility | singular_value, meaning}] in the order of s, kind one of
 * toggle, gain, minimum; and `smallest_singular_value` {value, s}, null if it wasn't requested. */
void km_singularities_record(const km_mechanism *mechanism, const km_mobility_sweep *sweep, km_value *record,
                             km_arena *arena);
/* Appends the smallest singular value and its minima, if requested. */
void km_singularities_print(const km_mobility_sweep *sweep, const char *unit, km_text *out);

#endif
