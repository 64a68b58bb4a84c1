/* The report about the answer to a question. */
#ifndef KM_REPORT_DOCUMENT_QUESTION_REPORT_H
#define KM_REPORT_DOCUMENT_QUESTION_REPORT_H

#include "report/plot/question_plot.h"

/* Of "advantage", asked with `transmission`, and of "forces". `html`: one self-contained file instead of PDF pages.
 * Appends the bytes. KM_USAGE: there is no report of this kind. */
km_status km_question_report(const km_answered *answer, const char *stopped_by, bool html, km_text *out,
                             km_error *error);

#endif
