/* The report about what holds a mechanism: a few pages to hand on. */
#ifndef KM_REPORT_DOCUMENT_STATICS_REPORT_H
#define KM_REPORT_DOCUMENT_STATICS_REPORT_H

#include "report/charts/statics_plot.h"
#include "report/document/document.h"

/* `statics` is the balance of a row, for what is statically indeterminate; `acting` says in words what acts. `html`:
 * one self-contained file instead of PDF pages. Appends the bytes. */
km_status km_statics_report(const km_plotted_statics *sweep, const km_statics *statics, const char *acting,
                            const char *stopped_by, const km_report_header *header, bool html, km_text *out,
                            km_error *error);
/* Its blocks, before they are rendered. */
void km_statics_report_make(km_document_maker *maker, const km_plotted_statics *sweep, const km_statics *statics,
                            const char *acting, const char *stopped_by);

#endif
