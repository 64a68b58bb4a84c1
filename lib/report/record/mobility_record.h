/* Mobility analyses as records (JSON) and as text. */
#ifndef KM_REPORT_RECORD_MOBILITY_RECORD_H
#define KM_REPORT_RECORD_MOBILITY_RECORD_H

#include "kmech/report.h"
#include "kmech/sweep.h"
#include "report/record/record.h"
#include "report/record/sweep_text.h"

/* Record of `kmob sweep --format json`. */
km_value *km_mobility_sweep_record(const km_mechanism *mechanism, const km_mobility_sweep *sweep,
                                   const km_sweep_redundancies *redundancies, const char *stopped_by, const char *name,
                                   km_arena *arena);
/* True if the coordinate can drive all moving parts in every row. */
bool km_sweep_drives(const km_mechanism *mechanism, const km_mobility_sweep *sweep, int coordinate);
/* Text summary: mobility, joints that can drive the range, dead points of the others. */
void km_mobility_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_mobility_sweep *sweep,
                             const km_sweep_redundancies *redundancies, const char *name, km_text *out);

#endif
