/* The plot of any columns of tables: one over another. */
#ifndef KM_REPORT_CHARTS_TABLE_PLOT_H
#define KM_REPORT_CHARTS_TABLE_PLOT_H

#include "kmech/report.h"
#include "report/plot/plot.h"

/* Builds the plot of km_table_chart_worded in the arena; `words` NULL: none. False when out of memory. */
bool km_table_plot_make(const km_plotted_table *tables, size_t count, size_t columns, const km_chart_words *words,
                        km_arena *arena, km_plot *out);

#endif
