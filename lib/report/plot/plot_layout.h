/* Layout of a plot, and the parts drawn by it. Private to report/plot. */
#ifndef KM_REPORT_PLOT_PLOT_LAYOUT_H
#define KM_REPORT_PLOT_PLOT_LAYOUT_H

#include "base/memory.h"
#include "report/canvas/canvas.h"
#include "report/plot/axis_ticks.h"
#include "report/plot/data_curve.h"
#include "report/plot/plot.h"

/* A name above the frame, to the right of a vertical line at its mark. */
typedef struct km_plot_flag {
  double x;         /* in the axis' units */
  double at, width; /* points from the frame's left edge; width of the name */
  const char *name; /* several names joined when their marks share a place */
  int own_colour;   /* index of the first */
  size_t row;       /* 0 is next to the frame */
} km_plot_flag;

typedef struct km_plot_flags {
  km_plot_flag *flags; /* marks from left to right */
  size_t count, rows;
} km_plot_flags;

/* All lengths in points. Cells are the grid's parts: a head, a frame, and a foot with the ticks. */
typedef struct km_plot_layout {
  const km_plot *plot;
  km_canvas *canvas;
  km_arena *arena;
  double width, height;
  bool fits;    /* true if the panels fit; otherwise nothing can be drawn */
  double scale; /* scale of letters and lines: 1 at the default size */
  km_font title, subtitle, heading, label, tick, name, mark;
  size_t columns, rows;
  double margin;
  double grid_top;               /* top of the first row of cells */
  double head, heading_height;   /* space above each frame; the part for the panel's title */
  double foot, mark_room;        /* beneath each frame; the part of it that mark signs take */
  double left, right;            /* space left and right of each frame; in the first column axis_left is added to
                                  * `left` */
  double axis_left, axis_bottom; /* space for y ticks and label; at the bottom for the x label */
  double frame_width, frame_height;
  km_axis x, *y;        /* y: one a panel, all the same unless the plot's panels have their own */
  km_plot_flags *flags; /* one a panel */
} km_plot_layout;

/* Computes the layout from plot, canvas and arena. Memory failures are recorded in the arena. */
void km_plot_layout_make(km_plot_layout *layout, double width, double height);
km_frame km_plot_layout_frame(const km_plot_layout *layout, size_t panel);
/* Default size of a plot, and its grid. */
void km_plot_layout_size(const km_plot *plot, double *width, double *height);

/* Names of marks as flags on a frame `frame_width` wide whose x axis goes from low to high. */
km_plot_flags km_plot_flags_make(const km_plot_layout *layout, const km_plot_panel *panel, double frame_width);
/* Width needed by flags to the right of a frame; frame and right margin together are `width` wide. */
double km_plot_flags_room(const km_plot_layout *layout, const km_plot_panel *panel, double width);
void km_plot_flags_draw(const km_plot_layout *layout, size_t panel);

/* Axes, grid lines, ticks and title of a panel. */
void km_plot_axes_draw(const km_plot_layout *layout, size_t panel);
/* The plot's title and subtitle, and the names of its axes. */
void km_plot_titles_draw(const km_plot_layout *layout);

/* Width needed by the names at the lines' ends to the right of the frame. */
double km_plot_names_room(const km_plot_layout *layout, const km_plot_panel *panel);
/* `curves` are those of the panel's series. */
void km_plot_names_draw(const km_plot_layout *layout, size_t panel, const km_curve *curves);

/* Moves ascending places apart, to `gap` at least and into low..high, as little as possible (least
 * squares). When they don't fit, they begin at low and go past high. */
void km_plot_spread(double *places, size_t count, double gap, double low, double high, km_arena *arena);

#endif
