/* Findings of a check as a record and as text. */
#ifndef KM_REPORT_RECORD_CHECK_RECORD_H
#define KM_REPORT_RECORD_CHECK_RECORD_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/diagnosis.h"

void km_findings_print(const km_findings *findings, const char *name, km_text *out);
/* Adds `findings` to a record. */
void km_findings_record(const km_findings *findings, km_value *record, km_arena *arena);

#endif
