/* Static balance as records (JSON) and as text. */
#ifndef KM_REPORT_RECORD_STATICS_RECORD_H
#define KM_REPORT_RECORD_STATICS_RECORD_H

#include "base/text.h"
#include "kmech/report.h"
#include "kmech/sweep.h"
#include "report/record/record.h"

/* Record of `kstatic sweep --format json`, and its text summary. */
km_value *km_statics_sweep_record(const km_mechanism *mechanism, const km_statics_sweep *sweep, const char *stopped_by,
                                  const char *name, km_arena *arena);
void km_statics_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_statics_sweep *sweep,
                            const char *name, km_text *out);

#endif
