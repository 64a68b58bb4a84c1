/* The plot of a simulation: coordinates, rates, driving forces and energies over time. */
#ifndef KM_REPORT_PLOT_HISTORY_PLOT_H
#define KM_REPORT_PLOT_HISTORY_PLOT_H

#include "base/memory.h"
#include "kmech/history.h"
#include "report/plot/plot.h"

/* What to show of a history's table, or of some of its rows. Everything is borrowed. */
typedef struct km_plotted_history {
  const km_mechanism *mechanism;
  const km_table *table;
  const km_crossing *crossings; /* of the definition */
  const km_crossing_met *met;
  int met_count;
  const char *name;  /* of the model */
  const int *joints; /* coordinates whose curves are drawn; NULL: up to eight that move most for their kind */
  int joint_count;
} km_plotted_history;

/* Panels above each other: coordinates and rates by unit, driving forces, mobility numbers where the table has them,
 * energies. False when out of memory. */
bool km_history_plot_make(const km_plotted_history *history, km_arena *arena, km_plot *out);
/* The same of a prescribed motion: driving forces, shaking force, coordinates. */
bool km_inverse_plot_make(const km_plotted_history *history, km_arena *arena, km_plot *out);

#endif
