/* Lines that lie on each other. */
#ifndef KM_REPORT_PLOT_OVERLAPPING_LINES_H
#define KM_REPORT_PLOT_OVERLAPPING_LINES_H

#include "report/plot/data_curve.h"

/* The pen of a panel's line `index` of the width `width`, which is drawn over those before it: its own, but long dashes
 * where it would hide another coloured line for half of its way or more. `curves` are those of the series. */
km_pen km_overlap_pen(const km_plot_series *series, const km_curve *curves, size_t index, double width);

#endif
