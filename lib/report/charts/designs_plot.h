/* Pictures of studies of designs: spreads of figures, what they depend on, quantiles along a motion, the way to the best
 * design. Each appends its bytes to `out`, where it doesn't draw on a canvas. KM_NO_RESULT: there is nothing to draw. */
#ifndef KM_REPORT_CHARTS_DESIGNS_PLOT_H
#define KM_REPORT_CHARTS_DESIGNS_PLOT_H

#include "kmech/report.h"
#include "report/plot/plot.h"

/* What is drawn, and how. */
typedef struct km_designs_shown {
  km_design_study *study;
  const km_design_study_def *def;
  const char *name; /* of the study, in subtitles */
  km_designs_plot plot;
  int index, band; /* of the figure, or of the question and its band */
  km_picture_format format;
  km_canvas *canvas; /* to draw on, in a place of this size, instead of a picture of its own in `out`; NULL: none */
  double width, height;
  bool only_try; /* nothing is drawn: is there something to draw? */
} km_designs_shown;

/* Renders a plot as the picture asks for, or fails if it couldn't be made; frees the arena. */
km_status km_designs_finish(const km_designs_shown *picture, bool made, const km_plot *plot, km_arena *arena,
                            km_text *out, km_error *error);

/* Draws what `plot`, `index` and `band` say: one of the following. */
km_status km_designs_draw(const km_designs_shown *picture, km_text *out, km_error *error);

/* How often a figure has which values, with its quantiles and limits. */
km_status km_designs_histogram(const km_designs_shown *picture, int figure, km_text *out, km_error *error);
/* The figure over each parameter's place in its spread: one panel a parameter, the strongest first. */
km_status km_designs_scatter(const km_designs_shown *picture, int figure, km_text *out, km_error *error);
/* Mean and its interval over the number of designs. */
km_status km_designs_convergence(const km_designs_shown *picture, int figure, km_text *out, km_error *error);
/* Quantiles of a band over the driver. */
km_status km_designs_bands(const km_designs_shown *picture, int question, int band, km_text *out, km_error *error);
/* An optimisation's goal over the designs that were asked: of each start, and the best so far. */
km_status km_designs_progress(const km_designs_shown *picture, km_text *out, km_error *error);
/* Both goals of all designs, and the front. */
km_status km_designs_front(const km_designs_shown *picture, km_text *out, km_error *error);
/* Of up to 64 designs over each other, of an optimisation of the start and the best: what a question answers, and the path
 * of the first point that it traces. */
km_status km_designs_answers(const km_designs_shown *picture, int question, km_text *out, km_error *error);
km_status km_designs_paths(const km_designs_shown *picture, int question, km_text *out, km_error *error);

#endif
