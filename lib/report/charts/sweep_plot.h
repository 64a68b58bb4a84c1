/* Columns of sweeps' tables as a plot: what the tools about leverage and forces share. */
#ifndef KM_REPORT_CHARTS_SWEEP_PLOT_H
#define KM_REPORT_CHARTS_SWEEP_PLOT_H

#include "base/memory.h"
#include "kmech/sweep.h"
#include "report/plot/plot.h"

/* One of the sweeps that share a plot. */
typedef struct km_swept {
  const km_mechanism *mechanism;
  const km_sweep_plan *plan;
  const km_sweep *motion;
  const char *name; /* name of the model */
} km_swept;

/* A column of one of them as a line. */
typedef struct km_swept_line {
  int sweep;
  size_t column;
  const char *name;
  int panel;
} km_swept_line;

typedef struct km_swept_mark {
  int sweep, panel;
  double s;
  const char *name;
} km_swept_mark;

/* A pole of a line: it grows without bound there, and its other side has nothing to do with this one. */
typedef struct km_swept_break {
  int sweep;
  size_t column;
  double s;
} km_swept_break;

typedef struct km_sweep_picture {
  const char *title, *note; /* note: added to the subtitle, NULL: none */
  const char *y_label;
  const km_swept *sweeps;
  int sweep_count;
  bool ordered; /* the sweeps are variants, whose order the colours show */
  const km_swept_line *lines;
  size_t line_count;
  const km_swept_mark *marks;
  size_t mark_count;
  const km_swept_break *breaks;
  size_t break_count;
  const char *const *panels; /* titles of the panels */
  int panel_count;           /* at least 1 */
  bool strip;                /* small drawings of three poses beneath */
} km_sweep_picture;

/* Builds the plot in the arena. Lines are cut at their poles alone, where arrowheads mark that they go on; past eight
 * lines in a panel the smaller ones are grey. False when out of memory. */
bool km_sweep_plot_make(const km_sweep_picture *picture, km_arena *arena, km_plot *out);

#endif
