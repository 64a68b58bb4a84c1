/* The plot of a simulation: coordinates, rates, driving forces and energies over time. */
#ifndef KM_REPORT_CHARTS_HISTORY_PLOT_H
#define KM_REPORT_CHARTS_HISTORY_PLOT_H

#include "kmech/report.h"
#include "report/plot/plot.h"

/* Builds the plot of km_history_chart in the arena. False when out of memory. */
bool km_history_plot_make(const km_plotted_history *history, km_arena *arena, km_plot *out);
/* Plot of km_inverse_chart. */
bool km_inverse_plot_make(const km_plotted_history *history, km_arena *arena, km_plot *out);

#endif
