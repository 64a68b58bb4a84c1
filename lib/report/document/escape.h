/* Text as HTML and SVG hold it. */
#ifndef KM_REPORT_DOCUMENT_ESCAPE_H
#define KM_REPORT_DOCUMENT_ESCAPE_H

#include "base/text.h"

/* Appends text in which no character means markup, inside an attribute neither; controls are shown
 * (km_text_visible). */
void km_html_escape(const char *text, km_text *out);

#endif
