/* Reports about motions over a driver's range and over time. */
#ifndef KM_REPORT_DOCUMENT_MOTION_REPORT_H
#define KM_REPORT_DOCUMENT_MOTION_REPORT_H

#include "kmech/report.h"
#include "report/document/document.h"

/* Add the blocks of an answer of kind "motion", and of kinds "run" and "inverse". `brief`: the answer, its tables and
 * the mechanism only. */
void km_motion_report_make(km_document_maker *maker, const km_answered *answer, const char *stopped_by, bool brief);
void km_history_report_make(km_document_maker *maker, const km_answered *answer, const char *stopped_by, bool brief);
/* True if the swing is one to report: the coordinate isn't the driver, isn't held, isn't of a ball joint, and moves. */
bool km_report_shows_swing(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_swing *swing);

#endif
