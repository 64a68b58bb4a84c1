/* Singular poses of a mobility sweep, told for people and programs. */
#ifndef KM_REPORT_RECORD_SINGULAR_VALUE_RECORD_H
#define KM_REPORT_RECORD_SINGULAR_VALUE_RECORD_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/sweep.h"

/* Adds `singularities` [{s, kind, joints | mobility | singular_value, meaning}] in the order of s, kind one of toggle,
 * gain, minimum; and `smallest_singular_value` {value, s}, null where it wasn't asked for. */
void km_singularities_record(const km_mechanism *mechanism, const km_mobility_sweep *sweep, km_value *record,
                             km_arena *arena);
/* The smallest singular value and its minima, where they were asked for. */
void km_singularities_print(const km_mobility_sweep *sweep, const char *unit, km_text *out);

#endif
