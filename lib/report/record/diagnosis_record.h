/* Finite mobility and redundant constraints as records and as text. */
#ifndef KM_REPORT_RECORD_DIAGNOSIS_RECORD_H
#define KM_REPORT_RECORD_DIAGNOSIS_RECORD_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/finite_mobility.h"
#include "kmech/idle.h"
#include "kmech/redundancy.h"

/* What is asked of a pose beyond its numbers. */
typedef struct km_diagnosis {
  km_finite_mobility finite;
  km_redundancies redundancies;
  km_idle_freedoms idle;
} km_diagnosis;

km_status km_diagnosis_find(const km_mechanism *mechanism, km_state *state, km_diagnosis *out, km_error *error);
void km_diagnosis_free(km_diagnosis *diagnosis);

/* Adds finite_mobility, motions, truncated, idle_mobility, idle_freedoms and redundancies to a record. */
void km_diagnosis_record(const km_mechanism *mechanism, const km_diagnosis *diagnosis, km_value *record,
                         km_arena *arena);
/* Adds `redundancies` to a record. */
void km_redundancies_record(const km_mechanism *mechanism, const km_redundancies *redundancies, km_value *record,
                            km_arena *arena);
void km_diagnosis_print(const km_mechanism *mechanism, const km_diagnosis *diagnosis, km_text *out);
/* One idle freedom in words: which bodies move in place, between which joints. */
void km_idle_statement(const km_mechanism *mechanism, const km_idle_freedom *idle, km_text *out);
/* One redundancy in words: which loop, what is constrained twice, where. */
void km_redundancy_statement(const km_mechanism *mechanism, const km_redundancy *redundancy, km_text *out);

#endif
