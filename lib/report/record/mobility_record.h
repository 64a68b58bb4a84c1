/* Mobility analyses as records (JSON) and as text for people. */
#ifndef KM_REPORT_RECORD_MOBILITY_RECORD_H
#define KM_REPORT_RECORD_MOBILITY_RECORD_H

#include "kmech/report.h"
#include "kmech/sweep.h"
#include "report/record/record.h"
#include "report/record/sweep_text.h"

/* What `kmob sweep --format json` gives. */
km_value *km_mobility_sweep_record(const km_mechanism *mechanism, const km_mobility_sweep *sweep,
                                   const km_sweep_redundancies *redundancies, const char *stopped_by, const char *name,
                                   km_arena *arena);
/* Could the coordinate drive everything that moves, over all rows? */
bool km_sweep_drives(const km_mechanism *mechanism, const km_mobility_sweep *sweep, int coordinate);
/* A summary to act on: freedoms, which joints could drive the range, where the others lose their grip. */
void km_mobility_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_mobility_sweep *sweep,
                             const km_sweep_redundancies *redundancies, const char *name, km_text *out);

#endif
