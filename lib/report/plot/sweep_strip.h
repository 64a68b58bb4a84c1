/* Small drawings of poses over a sweep, from first to last, for the strip beneath its plot. */
#ifndef KM_REPORT_PLOT_SWEEP_STRIP_H
#define KM_REPORT_PLOT_SWEEP_STRIP_H

#include "base/memory.h"
#include "kmech/sweep_plan.h"
#include "report/plot/plot.h"
#include "spatial/pose.h"

enum { KM_MOST_STRIP_POSES = 6 };

typedef struct km_sweep_strip {
  const km_mechanism *mechanism;
  const km_sweep_plan *plan;
  int count;
  km_pose *poses; /* [count · bodies] */
  double s[KM_MOST_STRIP_POSES];
} km_sweep_strip;

/* Poses of `count` rows of the sweep, evenly spaced, from the table's coordinates. A strip without height where there
 * is nothing to draw, or too much for its size. `out` is the strip's context and must outlive it. */
km_plot_strip km_sweep_strip_make(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_sweep *sweep,
                                  int count, km_arena *arena, km_sweep_strip *out);

/* The bodies' poses [body] at a row of a sweep's table; `q` [coordinate] and the state are used on the way. */
void km_row_pose(const km_mechanism *mechanism, const km_table *table, size_t row, km_state *state, double *q,
                 km_pose *poses);

#endif
