/* Static balance as records (JSON) and as text for people. */
#ifndef KM_REPORT_RECORD_STATICS_RECORD_H
#define KM_REPORT_RECORD_STATICS_RECORD_H

#include "base/text.h"
#include "kmech/statics_sweep.h"
#include "report/record/record.h"

/* What `kstatic at` gives (cli.md). NULL when out of memory (arena->failed). */
km_value *km_statics_record(const km_mechanism *mechanism, const km_state *state, const km_statics *statics,
                            const char *name, km_arena *arena);
void km_statics_print(const km_mechanism *mechanism, const km_statics *statics, const char *name, km_text *out);
/* What `kstatic sweep --format json` gives, and a summary to act on. */
km_value *km_statics_sweep_record(const km_mechanism *mechanism, const km_statics_sweep *sweep, const char *stopped_by,
                                  const char *name, km_arena *arena);
void km_statics_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_statics_sweep *sweep,
                            const char *name, km_text *out);
/* Which joints would move, the fastest first: "D by -1 rad, N by 0.9 m, …". */
void km_direction_words(const km_mechanism *mechanism, const km_statics *statics, int direction, km_text *out);

#endif
