/* Small drawings for the strip beneath a plot: poses over a sweep or a time, from first to last; of what is
 * compared, over each other. */
#ifndef KM_REPORT_CHARTS_SWEEP_STRIP_H
#define KM_REPORT_CHARTS_SWEEP_STRIP_H

#include "report/charts/sweep_plot.h"
#include "report/drawing/drawing.h"
#include "spatial/pose.h"

enum { KM_MAX_STRIP_POSES = 6 };

enum { KM_MAX_STRIP_LAYERS = 6 };

typedef struct km_sweep_strip {
  int count;                                    /* pictures, from left to right */
  int layers;                                   /* mechanisms over each other */
  km_drawing_def drawings[KM_MAX_STRIP_LAYERS]; /* picture k shows pose k of each; all share one scale */
  const char *captions[KM_MAX_STRIP_POSES];
  const char *names[KM_MAX_STRIP_LAYERS]; /* names of the compared models, in colours[k]; NULL: one mechanism */
  int colours[KM_MAX_STRIP_LAYERS];
} km_sweep_strip;

/* Poses of `count` rows of the sweep, evenly spaced, from the table's coordinates. A strip without height where there
 * is nothing to draw, or too much for its size. `out` is the strip's context and must outlive it. */
km_plot_strip km_sweep_strip_make(const km_swept *sweep, int count, km_arena *arena, km_sweep_strip *out);

/* Strip of a motion over time, whose table has the time in its first column. Empty if the mechanism moves far away. */
km_plot_strip km_motion_strip_make(const km_mechanism *mechanism, const km_table *table, int count, km_arena *arena,
                                   km_sweep_strip *out);

/* Models or variants overlaid in the colours of their curves: at the beginning, middle and end of the shared stroke,
 * or of their own rows if their drivers have different names. If not all fit: the first, the last and some between. */
km_plot_strip km_comparison_strip_make(const km_swept *sweeps, int count, bool ordered, km_arena *arena,
                                       km_sweep_strip *out);

#endif
