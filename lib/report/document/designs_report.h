/* A short report of a study of designs: what was asked, the main table, what became of the designs. */
#ifndef KM_REPORT_DOCUMENT_DESIGNS_REPORT_H
#define KM_REPORT_DOCUMENT_DESIGNS_REPORT_H

#include "base/text.h"
#include "kmech/design_study.h"

/* As HTML or PDF. Appends the bytes. KM_IO, KM_MEMORY, KM_INTERNAL. */
km_status km_designs_report(km_design_study *study, const km_design_study_def *def, const char *name, bool html,
                            km_text *out, km_error *error);

#endif
