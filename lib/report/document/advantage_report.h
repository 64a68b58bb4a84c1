/* The report about a mechanism's leverage: a few pages to hand on. */
#ifndef KM_REPORT_DOCUMENT_ADVANTAGE_REPORT_H
#define KM_REPORT_DOCUMENT_ADVANTAGE_REPORT_H

#include "kmech/transfer.h"
#include "report/charts/advantage_plot.h"
#include "report/document/document.h"

/* Adds the blocks of a sweep with transmission columns; `transmission` of the last row has the reasons of undefined
 * metrics. `brief`: the answer, its facts and the mechanism only. */
void km_advantage_report_make(km_document_maker *maker, const km_plotted_advantage *sweep,
                              const km_transmission *transmission, const char *stopped_by, bool brief);

#endif
