/* The plot of mobility numbers over a sweep. */
#ifndef KM_REPORT_CHARTS_MOBILITY_PLOT_H
#define KM_REPORT_CHARTS_MOBILITY_PLOT_H

#include "base/memory.h"
#include "kmech/sweep.h"
#include "report/plot/plot.h"

/* One of the sweeps that share a plot. */
typedef struct km_plotted_sweep {
  const km_mechanism *mechanism;
  const km_sweep_plan *plan;
  const km_mobility_sweep *sweep;
  const char *name; /* name of the model */
  const int *shown; /* [shown_count] coordinates whose numbers are drawn; NULL: all, of several sweeps the driver's */
  int shown_count;
} km_plotted_sweep;

/* Builds the plot in the arena. Joints with equal numbers share a line; with more than eight lines each substructure
 * has its own panel. Several sweeps are overlaid in different colours; `ordered`: variants, whose colours are
 * ordered. False when out of memory. */
bool km_mobility_plot_make(const km_plotted_sweep *sweeps, int count, bool ordered, km_arena *arena, km_plot *out);

#endif
