/* Comparison of plots with the tables from which they are made. */
#ifndef KM_TESTS_SHOWN_H
#define KM_TESTS_SHOWN_H

#include "support/support.h"

#include "report/plot/plot.h"

/* A cell of the column whose name is `prefix` and `name`; fails the test if there is none. */
double shown_cell(const km_table *table, size_t row, const char *prefix, const char *name);
/* Equal, or both NaN. */
bool shown_same(double a, double b);

/* Every row of the table's column is a point of the line, at its own place. */
void check_line(const km_plot_series *line, const km_table *table, const char *prefix, const char *name,
                double tolerance);
/* Comparison for every label of a line named "A, B, C"; returns their number. */
int check_lines(const km_plot_series *line, const km_table *table, const char *prefix, double tolerance);
/* The first eight lines by their largest value have the colours 0, 1, …, each its own, the others are grey. */
void check_colours(const km_plot_panel *panel);

#endif
