/* Another axis across a plot: x becomes another quantity of the same rows.
 *
 *   x -> to(x),  piecewise linear through (from[i], to[i]) */
#ifndef KM_REPORT_PLOT_PLOT_OVER_H
#define KM_REPORT_PLOT_PLOT_OVER_H

#include "base/memory.h"
#include "report/plot/plot.h"

typedef struct km_plot_over {
  const double *from, *to; /* [count] x of the plots, in ascending or descending order, and the quantity */
  size_t count;
  const char *label; /* axis label with unit */
  size_t column;     /* column of the quantity in its table */
} km_plot_over;

/* Replaces x of all series and marks, and the label. The new arrays are in the arena. False without memory. */
bool km_plot_set_over(km_plot *plot, const km_plot_over *over, km_arena *arena);

#endif
