/* The plot of answers to one question, of one model or several. */
#ifndef KM_REPORT_PLOT_QUESTION_PLOT_H
#define KM_REPORT_PLOT_QUESTION_PLOT_H

#include "kmech/question.h"
#include "report/plot/plot.h"

/* One of the answers that share a plot. */
typedef struct km_answered {
  const km_mechanism *mechanism;
  const km_question *question; /* with an answer; all of one kind */
  const char *name;            /* of the model, or the variant */
  const int *shown;            /* [shown_count] the coordinates whose curves are drawn; NULL: by default all, of several
                                * answers the driver's */
  int shown_count;
} km_answered;

/* Answers of several models or variants in one picture. */
typedef struct km_comparison {
  const km_answered *answers;
  int count;
  bool ordered; /* variants, whose order the colours show; else models, whose colours differ most */
} km_comparison;

/* The given columns of the answers' tables over the way s: all tables have the same columns. */
km_status km_question_plot_columns(const km_comparison *comparison, const size_t *columns, size_t count,
                                   km_canvas_format format, km_text *out, km_error *error);
/* Appends the picture's bytes. */
km_status km_question_plot(const km_comparison *comparison, km_canvas_format format, km_text *out, km_error *error);

#endif
