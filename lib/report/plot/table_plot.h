/* The plot of any columns of tables: one over another. */
#ifndef KM_REPORT_PLOT_TABLE_PLOT_H
#define KM_REPORT_PLOT_TABLE_PLOT_H

#include "base/memory.h"
#include "kmech/table.h"
#include "report/plot/plot.h"

/* One of the tables that share a plot. Everything is borrowed. */
typedef struct km_plotted_table {
  const km_table *table;
  const char *name;
  size_t x;
  const size_t *y; /* [columns] the same columns of every table, with the same units */
} km_plotted_table;

/* Columns of one unit share a panel; others stand in panels above each other. The scales of x and y are equal where
 * both are lengths and the curve is one in a plane: coordinates of points, or an x that goes forth and back. Numbers
 * that aren't finite break a curve. */
km_status km_table_plot(const km_plotted_table *tables, size_t count, size_t columns, km_canvas_format format,
                        km_text *out, km_error *error);
/* The same, before it is drawn. False when out of memory. */
bool km_table_plot_make(const km_plotted_table *tables, size_t count, size_t columns, km_arena *arena, km_plot *out);

#endif
