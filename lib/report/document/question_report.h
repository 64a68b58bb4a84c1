/* The blocks of the report about each kind of question. */
#ifndef KM_REPORT_DOCUMENT_QUESTION_REPORT_H
#define KM_REPORT_DOCUMENT_QUESTION_REPORT_H

#include "kmech/report.h"
#include "report/document/document.h"

/* KM_USAGE: there is no answer with rows, or no report about its kind. */
km_status km_question_report_check(const km_answered *answer, km_error *error);
/* Adds the blocks of a checked answer; `brief`: the answer, its tables and the mechanism only. */
void km_question_report_make(km_document_maker *maker, const km_answered *answer, const char *stopped_by, bool brief);
/* Name of the tool whose report it is. */
const char *km_question_report_tool(const km_question *question);

#endif
