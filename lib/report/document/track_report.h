/* Blocks of the report about tracks. */
#ifndef KM_REPORT_DOCUMENT_TRACK_REPORT_H
#define KM_REPORT_DOCUMENT_TRACK_REPORT_H

#include "kmech/report.h"
#include "report/document/document.h"

/* Adds the answer in a sentence, facts, the joints against their limits, and the table of the methods. */
void km_tracks_summary_add(km_document_maker *maker, const km_tracks *tracks);

#endif
