/* Pictures of studies of designs: spreads of figures, what they depend on, quantiles along a motion, the way to the
 * best design. Each appends its bytes to `out`, where it doesn't draw on a canvas. KM_NO_RESULT: there is nothing to
 * draw. */
#ifndef KM_REPORT_CHARTS_DESIGNS_PLOT_H
#define KM_REPORT_CHARTS_DESIGNS_PLOT_H

#include "kmech/report.h"
#include "report/plot/plot.h"

/* Options of a picture of a study. */
typedef struct km_designs_shown {
  km_design_study *study;
  const km_design_study_def *def;
  const char *name; /* name of the study, for subtitles */
  km_designs_plot plot;
  int index, band; /* name of the figure, or of the question and its band */
  km_picture_format format;
  km_canvas *canvas; /* canvas to draw on, in a rectangle of this size, instead of a picture in `out`; NULL: none */
  double width, height;
  bool only_try; /* only checks whether there is something to draw */
} km_designs_shown;

/* Renders a plot with the options of the picture, or returns its failure; frees the arena. */
km_status km_designs_finish(const km_designs_shown *picture, bool made, const km_plot *plot, km_arena *arena,
                            km_text *out, km_error *error);

/* Draws what `plot`, `index` and `band` say: one of the following. */
km_status km_designs_draw(const km_designs_shown *picture, km_text *out, km_error *error);

/* Histogram of a figure, with quantiles and limits. */
km_status km_designs_histogram(const km_designs_shown *picture, int figure, km_text *out, km_error *error);
/* The figure over each parameter's place in its spread: one panel a parameter, the strongest first. */
km_status km_designs_scatter(const km_designs_shown *picture, int figure, km_text *out, km_error *error);
/* Mean and its interval over the number of designs. */
km_status km_designs_convergence(const km_designs_shown *picture, int figure, km_text *out, km_error *error);
/* Quantiles of a band over the driver. */
km_status km_designs_bands(const km_designs_shown *picture, int question, int band, km_text *out, km_error *error);
/* Goal of an optimisation over the evaluated designs: for each start, and the best so far. */
km_status km_designs_progress(const km_designs_shown *picture, km_text *out, km_error *error);
/* Both goals of all designs, and the front. */
km_status km_designs_front(const km_designs_shown *picture, km_text *out, km_error *error);
/* Overlay of up to 64 designs, or of start and best design of an optimisation: answers of a question, and the path
 * of its first traced point. */
km_status km_designs_answers(const km_designs_shown *picture, int question, km_text *out, km_error *error);
km_status km_designs_paths(const km_designs_shown *picture, int question, km_text *out, km_error *error);

#endif
