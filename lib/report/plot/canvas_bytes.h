/* Finished pictures, corrected. Private to report/plot. */
#ifndef KM_REPORT_PLOT_CANVAS_BYTES_H
#define KM_REPORT_PLOT_CANVAS_BYTES_H

#include "base/text.h"

/* Takes out the name of an SVG's page, which depends on the process. The picture begins at `start`. */
void km_svg_drop_id(km_text *out, size_t start);

#endif
