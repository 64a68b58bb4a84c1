/* The plot of actuator forces over a sweep. */
#ifndef KM_REPORT_PLOT_STATICS_PLOT_H
#define KM_REPORT_PLOT_STATICS_PLOT_H

#include "kmech/statics_sweep.h"
#include "report/plot/sweep_plot.h"

/* One of the sweeps that share a plot. */
typedef struct km_plotted_statics {
  km_swept swept;
  const km_statics_sweep *sweep;
  const int *shown; /* [shown_count] coordinates whose forces are drawn; NULL: all actuators */
  int shown_count;
} km_plotted_statics;

/* The column of an actuator's force in the sweep's table. */
size_t km_force_column(const km_statics_sweep *sweep, int actuator);

/* A line an actuator; torques in a panel of their own. Actuators whose forces agree share a line. */
km_status km_statics_plot(const km_plotted_statics *sweeps, int count, bool ordered, km_canvas_format format,
                          km_text *out, km_error *error);
/* The same, built for a page of a report. False when out of memory. */
bool km_statics_plot_make(const km_plotted_statics *sweeps, int count, bool ordered, bool strip, km_arena *arena,
                          km_plot *out);

#endif
