/* Comparison of plots with the tables from which they are made. */
#include "support/shown.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

double shown_cell(const km_table *table, size_t row, const char *prefix, const char *name) {
  char text[400];
  snprintf(text, sizeof text, "%s%s", prefix, name);
  int column = km_table_find(table, text);
  if (column < 0)
    fail_msg("the table has no column %s", text);
  return km_table_row(table, row)[column];
}

bool shown_same(double a, double b) {
  return a == b || (isnan(a) && isnan(b));
}

void check_line(const km_plot_series *line, const km_table *table, const char *prefix, const char *name,
                double tolerance) {
  for (size_t r = 0; r < km_table_rows(table); ++r) {
    double s = shown_cell(table, r, "", "s"), want = shown_cell(table, r, prefix, name);
    bool found = false;
    for (size_t i = 0; i < line->count && !found; ++i)
      found = line->x[i] == s && (shown_same(line->y[i], want) || fabs(line->y[i] - want) <= tolerance);
    if (!found)
      fail_msg("row %zu of %s%s isn't drawn in the line %s", r, prefix, name, line->name);
  }
}

int check_lines(const km_plot_series *line, const km_table *table, const char *prefix, double tolerance) {
  char names[800];
  int count = 0;
  snprintf(names, sizeof names, "%s", line->name);
  for (char *label = names, *next; label; label = next, ++count) {
    next = strstr(label, ", ");
    if (next) {
      *next = '\0';
      next += 2;
    }
    check_line(line, table, prefix, label, tolerance);
  }
  return count;
}

void check_colours(const km_plot_panel *panel) {
  unsigned seen = 0;
  double least = HUGE_VAL, most_grey = 0.0;
  int coloured = 0;
  for (size_t i = 0; i < panel->series_count; ++i) {
    const km_plot_series *line = &panel->series[i];
    double largest = 0.0;
    for (size_t k = 0; k < line->count; ++k)
      largest = fmax(largest, isfinite(line->y[k]) ? fabs(line->y[k]) : 0.0);
    if (line->colour < 0) {
      most_grey = fmax(most_grey, largest);
      continue;
    }
    assert_true(line->colour < 8);
    assert_false(seen >> line->colour & 1);
    seen |= 1u << line->colour;
    least = fmin(least, largest);
    ++coloured;
  }
  assert_true(most_grey <= least);
  assert_int_equal(coloured, panel->series_count < 8 ? panel->series_count : 8);
  assert_int_equal(seen, (1u << coloured) - 1u);
}
