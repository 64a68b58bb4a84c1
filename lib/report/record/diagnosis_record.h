/* Finite mobility and redundant constraints as records and as text. */
#ifndef KM_REPORT_RECORD_DIAGNOSIS_RECORD_H
#define KM_REPORT_RECORD_DIAGNOSIS_RECORD_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/mobility.h"
#include "kmech/report.h"

/* Adds `redundancies` to a record. */
void km_redundancies_record(const km_mechanism *mechanism, const km_redundancies *redundancies, km_value *record,
                            km_arena *arena);
/* Adds `remedy_set` to a record. */
void km_remedy_set_record(const km_mechanism *mechanism, const km_remedy_set *set, km_value *record, km_arena *arena);
/* The joint types that together end all redundant constraints, as text. */
void km_remedy_set_print(const km_mechanism *mechanism, const km_remedy_set *set, km_text *out);

#endif
