/* Reports about motions over a driver's range and over time. */
#ifndef KM_REPORT_DOCUMENT_MOTION_REPORT_H
#define KM_REPORT_DOCUMENT_MOTION_REPORT_H

#include "kmech/report.h"

/* Reports of answers of kind "motion", and of kinds "run" and "inverse". `html`: one self-contained file instead of PDF
 * pages. Append the bytes. KM_MEMORY. */
km_status km_motion_report(const km_answered *answer, const char *stopped_by, bool html, km_text *out, km_error *error);
km_status km_history_report(const km_answered *answer, const char *stopped_by, bool html, km_text *out,
                            km_error *error);

#endif
