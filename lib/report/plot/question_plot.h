/* The plot of answers to one question, of one model or several. */
#ifndef KM_REPORT_PLOT_QUESTION_PLOT_H
#define KM_REPORT_PLOT_QUESTION_PLOT_H

#include "kmech/question.h"
#include "report/plot/plot.h"

/* One of the answers that share a plot. */
typedef struct km_answered {
  const km_mechanism *mechanism;
  const km_question *question; /* with an answer; all of one kind */
  const char *name;            /* of the model */
} km_answered;

/* Appends the picture's bytes. */
km_status km_question_plot(const km_answered *answers, int count, km_canvas_format format, km_text *out,
                           km_error *error);

#endif
