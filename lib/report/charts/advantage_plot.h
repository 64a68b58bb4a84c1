/* The plot of mechanical advantage over a sweep. */
#ifndef KM_REPORT_CHARTS_ADVANTAGE_PLOT_H
#define KM_REPORT_CHARTS_ADVANTAGE_PLOT_H

#include "kmech/sweep.h"
#include "report/charts/sweep_plot.h"

/* One of the sweeps that share a plot. */
typedef struct km_plotted_advantage {
  km_swept swept;
  const km_advantage_sweep *sweep;
} km_plotted_advantage;

/* Builds the plot in the arena. `ordered`: variants, whose order the colours show; `strip`: with small drawings
 * beneath. False when out of memory. */
bool km_advantage_plot_make(const km_plotted_advantage *sweeps, int count, bool ordered, bool strip, km_arena *arena,
                            km_plot *out);
/* The column of the mechanical advantage in the sweep's table, or of the ratio of forces with friction. */
size_t km_advantage_column(const km_advantage_sweep *sweep, bool friction);
/* "MA 0", "MA ∞" … : what a toggle is called in pictures. */
const char *km_advantage_toggle_name(const km_advantage_toggle *toggle);

#endif
