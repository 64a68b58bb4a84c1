/* Finite mobility and redundant constraints as records and as text. */
#ifndef KM_REPORT_RECORD_DIAGNOSIS_RECORD_H
#define KM_REPORT_RECORD_DIAGNOSIS_RECORD_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/diagnosis.h"

/* Adds finite_mobility, motions, truncated, idle_mobility, idle_freedoms and redundancies to a record. */
void km_diagnosis_record(const km_mechanism *mechanism, const km_diagnosis *diagnosis, km_value *record,
                         km_arena *arena);
/* Adds `redundancies` to a record. */
void km_redundancies_record(const km_mechanism *mechanism, const km_redundancies *redundancies, km_value *record,
                            km_arena *arena);
/* `all`: also what planar loops have by nature. */
void km_diagnosis_print(const km_mechanism *mechanism, const km_diagnosis *diagnosis, bool all, km_text *out);

#endif
