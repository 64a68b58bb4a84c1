/* Line plots: a description in, the bytes of a picture out. Knows nothing of mechanisms. */
#ifndef KM_REPORT_PLOT_PLOT_H
#define KM_REPORT_PLOT_PLOT_H

#include "base/text.h"
#include "kmech/base.h"
#include "report/canvas/canvas.h"

/* A line through (x[i], y[i]), broken where either is not finite or beyond 1e300. Pointers are
 * borrowed. */
typedef struct km_plot_series {
  const char *name; /* UTF-8, written at the line's end; markup is not interpreted */
  const double *x, *y;
  size_t count;
  int colour;         /* index into the palette (palette.h); -1 grey (context line) */
  int dash;           /* index into its dash patterns; 0 solid */
  const double *base; /* [count] the area between y and this is filled lightly; NULL: none is */
} km_plot_series;

/* A named position on the x axis (a toggle, a limit, a dead centre). */
typedef struct km_plot_mark {
  double x;
  const char *name; /* NULL: the place is marked, not named */
  int own_colour;   /* 0: the ink of marks; else 1 + the index into the palette */
} km_plot_mark;

typedef struct km_plot_panel {
  const char *title;    /* NULL: none */
  const char *y_label;  /* y axis of a plot whose panels have their own */
  double y_low, y_high; /* range of its own y axis; both 0: fitted to the data */
  const km_plot_series *series;
  size_t series_count;
  const km_plot_mark *marks;
  size_t mark_count;
} km_plot_panel;

/* Pictures in a strip below the axes, drawn by the caller into a given rectangle. */
typedef struct km_plot_strip {
  double height; /* points; 0: no strip */
  void (*draw)(void *context, km_canvas *canvas, double top, double width);
  void *context;
} km_plot_strip;

typedef struct km_plot {
  const char *title, *subtitle;
  const char *x_label, *y_label; /* labels with units: "driver K (mm)" */
  double y_low, y_high;          /* both 0, or own_y: fitted to the data with round ticks */
  const km_plot_panel *panels;   /* small multiples with common axes */
  size_t panel_count;
  bool own_y; /* the panels are stacked, each with its own y axis and y_label */
  bool equal; /* a unit is as long along x as along y: for curves in a plane */
  km_plot_strip strip;
  double width, height; /* in points (1/72 inch), without the strip; 0: chosen from the number of panels */
} km_plot;

/* Appends the picture's bytes to `out`. Equal plots give equal bytes (no date, no random id). KM_USAGE (a page too
 * small or too large), KM_MEMORY or KM_INTERNAL (a failure of the graphics library); `out` is then unchanged. */
km_status km_plot_render(const km_plot *plot, km_picture_format format, km_text *out, km_error *error);

/* Draws the plot, without its strip, at the origin of a page that is there already. */
km_status km_plot_place(const km_plot *plot, km_canvas *canvas, double width, double height, km_error *error);

#endif
