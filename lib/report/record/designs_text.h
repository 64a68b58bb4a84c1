/* What a study of designs came to, as text for people and as a record. */
#ifndef KM_REPORT_RECORD_DESIGNS_TEXT_H
#define KM_REPORT_RECORD_DESIGNS_TEXT_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/design_study.h"

/* Tables of figures of merit, with the best marked; statistics of a sample; what an optimisation found. KM_IO, KM_MEMORY. */
km_status km_designs_print(km_design_study *study, const km_design_study_def *def, const char *name, km_text *out,
                           km_error *error);
/* Every design as one row: number, name, parameters, outcome, figures. */
km_status km_designs_csv(const km_design_study *study, const km_design_study_def *def, km_text *out, km_error *error);
/* The same as JSON, with the statistics. The record is the arena's. */
km_status km_designs_record(km_design_study *study, const km_design_study_def *def, const char *name, km_arena *arena,
                            km_value **out, km_error *error);
/* "as built", "pivot=33, crank=0.6", "17": what a design is called. */
void km_design_label(const km_design_study *study, const km_design_study_def *def, int design, km_text *out);

#endif
