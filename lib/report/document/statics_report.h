/* The report about what holds a mechanism: a few pages to hand on. */
#ifndef KM_REPORT_DOCUMENT_STATICS_REPORT_H
#define KM_REPORT_DOCUMENT_STATICS_REPORT_H

#include "report/charts/statics_plot.h"
#include "report/document/document.h"

/* Adds its blocks. `statics` is the balance of a row, for what is statically indeterminate; `acting` says in words what
 * acts. `brief`: the answer, its facts, the largest forces and the mechanism only. */
void km_statics_report_make(km_document_maker *maker, const km_plotted_statics *sweep, const km_statics *statics,
                            const char *acting, const char *stopped_by, bool brief);

#endif
