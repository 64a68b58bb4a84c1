/* The plot of actuator forces over a sweep. */
#ifndef KM_REPORT_CHARTS_STATICS_PLOT_H
#define KM_REPORT_CHARTS_STATICS_PLOT_H

#include "kmech/sweep.h"
#include "report/charts/sweep_plot.h"

/* One of the sweeps that share a plot. */
typedef struct km_plotted_statics {
  km_swept swept;
  const km_statics_sweep *sweep;
  const int *shown; /* [shown_count] coordinates whose forces are drawn; NULL: all actuators */
  int shown_count;
} km_plotted_statics;

/* The column of an actuator's force in the sweep's table. */
size_t km_force_column(const km_statics_sweep *sweep, int actuator);

/* Builds the plot in the arena: a line an actuator; torques in a panel of their own. Actuators whose forces agree
 * share a line. `ordered`, `strip` as in km_advantage_plot_make. False when out of memory. */
bool km_statics_plot_make(const km_plotted_statics *sweeps, int count, bool ordered, bool strip, km_arena *arena,
                          km_plot *out);

#endif
