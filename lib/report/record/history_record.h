/* The record of a simulation. */
#ifndef KM_REPORT_RECORD_HISTORY_RECORD_H
#define KM_REPORT_RECORD_HISTORY_RECORD_H

#include "base/value.h"
#include "kmech/history.h"

/* kmech, tool, model … figures, events, columns, rows, complete, stopped_by. NULL when out of memory. */
const km_value *km_history_record(const km_mechanism *mechanism, const km_history_def *def, const km_history *history,
                                  const char *stopped_by, const char *name, km_arena *arena);
/* The same of a motion that is prescribed as a whole. */
const km_value *km_inverse_record(const km_mechanism *mechanism, const km_history *history, const char *stopped_by,
                                  const char *name, km_arena *arena);

#endif
