/* Mechanical advantage as records (JSON) and as text. */
#ifndef KM_REPORT_RECORD_ADVANTAGE_RECORD_H
#define KM_REPORT_RECORD_ADVANTAGE_RECORD_H

#include "base/text.h"
#include "kmech/report.h"
#include "kmech/sweep.h"
#include "kmech/transfer.h"
#include "report/record/record.h"

/* Record of `kma sweep --format json`, and its text summary. */
km_value *km_advantage_sweep_record(const km_mechanism *mechanism, const km_advantage_sweep *sweep,
                                    const char *stopped_by, const char *name, km_arena *arena);
void km_advantage_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_advantage_sweep *sweep,
                              const char *name, km_text *out);
/* Label of the hinge whose transmission angle a column has; NULL: another column, a hinge of the link that the input
 * turns, where the angle is 0 at each dead point of the output, or one where it stays below 1 degree. */
const char *km_transmission_hinge(const km_mechanism *mechanism, const km_advantage_sweep *sweep, size_t column);
/* MA at the end over MA at the start; NaN: not finite at an end, or 0 at the start. */
double km_progression(const km_advantage_sweep *sweep);
/* " (end/start 0.597: falls by 40.3 %)", of the size; nothing where there is no progression. */
void km_progression_words(const km_advantage_sweep *sweep, km_text *out);
/* "is 2.4: …" in words: what the state and the method mean. */
void km_advantage_words(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                        const km_advantage *advantage, km_text *out);

#endif
