/* Small drawings for the strip beneath a plot: poses over a sweep, from first to last, or what is compared side by side. */
#ifndef KM_REPORT_PLOT_SWEEP_STRIP_H
#define KM_REPORT_PLOT_SWEEP_STRIP_H

#include "report/plot/sweep_plot.h"
#include "spatial/pose.h"

enum { KM_MOST_STRIP_POSES = 6 };

/* One small drawing: the pose `full` of several that share its scale. */
typedef struct km_strip_picture {
  const km_mechanism *mechanism;
  const km_pose *poses; /* [pose_count · bodies] */
  size_t pose_count, full;
  const char *caption;
  int colour; /* of the caption; -1: grey */
} km_strip_picture;

typedef struct km_sweep_strip {
  int count;
  km_strip_picture pictures[KM_MOST_STRIP_POSES];
} km_sweep_strip;

/* Poses of `count` rows of the sweep, evenly spaced, from the table's coordinates. A strip without height where there
 * is nothing to draw, or too much for its size. `out` is the strip's context and must outlive it. */
km_plot_strip km_sweep_strip_make(const km_swept *sweep, int count, km_arena *arena, km_sweep_strip *out);

/* The models or variants of a comparison at the middle row of each, in the colours of their curves; of more than fit the
 * first, the last and some between. */
km_plot_strip km_comparison_strip_make(const km_swept *sweeps, int count, bool ordered, km_arena *arena,
                                       km_sweep_strip *out);

/* The bodies' poses [body] at a row of a sweep's table; `q` [coordinate] and the state are used on the way. */
void km_row_pose(const km_mechanism *mechanism, const km_table *table, size_t row, km_state *state, double *q,
                 km_pose *poses);

#endif
