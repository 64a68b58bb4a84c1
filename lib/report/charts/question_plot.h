/* The plot of answers to one question, of one model or several. */
#ifndef KM_REPORT_CHARTS_QUESTION_PLOT_H
#define KM_REPORT_CHARTS_QUESTION_PLOT_H

#include "kmech/report.h"
#include "report/plot/plot.h"

/* Builds the plot of one answer or several of one kind in the arena. KM_MEMORY. */
km_status km_question_plot_make(const km_comparison *comparison, km_arena *arena, km_plot *out, km_error *error);

#endif
