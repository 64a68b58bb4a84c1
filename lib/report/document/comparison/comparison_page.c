/* The first page of a report about several models, variants or studies: which figures differ and by how much. */
#include "report/document/comparison/comparison_page.h"

#include "report/canvas/palette.h"
#include "report/document/sweep_report.h"

#include <math.h>
#include <string.h>

enum {
  LEAD_FIGURES = 2,     /* figures that the lead names */
  SIDE_BY_SIDE = 5,     /* as many compared things are columns, so that a page is as wide as they need */
  MOST_ROWS = 8,        /* rows of figures that leave space for the curves on the page */
  MOST_COLUMNS = 3,     /* columns of figures, where the compared things are rows */
  MOST_EQUAL_NAMED = 8, /* equal figures that are named */
  MOST_PANELS = 2
};
static const double panel_height = 84, plot_margin = 40; /* points */
static const double lone_panel = 1.8;                    /* height of the only panel, in panels */

static const char *unit_words(km_document_maker *k, const km_compared_figure *figure) {
  return figure->unit[0] ? km_document_format(k, " %s", km_report_unit(k, figure->unit)) : "";
}

/* "50 % more", "3.1 times as much"; empty where the sizes can't be related. */
static const char *difference_words(km_document_maker *k, double low, double high) {
  if (!(low > 0.0) || !(high > low))
    return "";
  const double ratio = high / low;
  return ratio < 2.0 ? km_document_format(k, " (%.3g %% more)", 100.0 * (ratio - 1.0))
                     : km_document_format(k, " (%.3g times as much)", ratio);
}

static int find_value(const km_compared_row *row, int count, double value) {
  for (int i = 0; i < count; ++i)
    if (row->values[i] == value)
      return i;
  return -1;
}

/* Five digits, as many as figures are compared by. */
static const char *number_words(km_document_maker *k, double value) {
  return isfinite(value) ? km_document_format(k, "%.5g", value) : km_report_number(k, value);
}

/* True if the figure of an earlier row has equal extremes: of two joints whose angles add up, one is named. */
static bool is_repeated(const km_compared_rows *rows, size_t r) {
  for (size_t i = 0; i < r; ++i)
    if (strcmp(rows->items[i].figure->unit, rows->items[r].figure->unit) == 0 &&
        fabs(rows->items[i].low - rows->items[r].low) <= 1e-9 * fabs(rows->items[r].high) &&
        fabs(rows->items[i].high - rows->items[r].high) <= 1e-9 * fabs(rows->items[r].high))
      return true;
  return false;
}

/* "largest acceleration of C from 12.3 rad/s^2 with crank=20 to 18.4 rad/s^2 with crank=30 (50 % more)". */
static void add_difference(km_document_maker *k, const km_compared_row *row, const char *const *names, int count,
                           km_text *out) {
  const char *unit = unit_words(k, row->figure);
  int least = find_value(row, count, row->low), greatest = find_value(row, count, row->high);
  km_text_format(out, "%s from %s%s with %s to %s%s with %s%s", row->figure->name, number_words(k, row->low), unit,
                 names[least], number_words(k, row->high), unit, names[greatest],
                 difference_words(k, row->low, row->high));
}

/* The thing with the most best values; -1: none has, or several have as many. */
static int find_best(const km_compared_rows *rows, int count, size_t *wins, size_t *of) {
  int best = -1;
  *wins = *of = 0;
  for (size_t r = 0; r < rows->different; ++r)
    *of += rows->items[r].best >= 0;
  for (int i = 0; i < count; ++i) {
    size_t won = 0;
    for (size_t r = 0; r < rows->different; ++r)
      won += rows->items[r].best == i;
    if (won > *wins) {
      *wins = won;
      best = i;
    } else if (won == *wins) {
      best = -1;
    }
  }
  return best;
}

static void add_lead(km_document_maker *k, const char *const *names, int count, const char *kinds,
                     const km_compared_rows *rows) {
  km_text text = {0};
  size_t wins, of, named = 0;
  const int best = find_best(rows, count, &wins, &of);
  if (rows->different == 0)
    km_text_format(&text, "%s",
                   rows->count
                       ? km_document_format(k, "The %d %s are equal in all %zu figures.", count, kinds, rows->count)
                       : km_document_format(k, "The %d %s have no figure to compare.", count, kinds));
  else
    km_text_format(&text, "The %d %s differ most in the ", count, kinds);
  for (size_t r = 0; r < rows->different && named < LEAD_FIGURES; ++r)
    if (rows->items[r].low < rows->items[r].high && !is_repeated(rows, r)) {
      km_text_add(&text, named++ ? "; " : "");
      add_difference(k, &rows->items[r], names, count, &text);
    }
  if (rows->different && named == 0)
    km_text_format(&text, "%s, which only some of them have", rows->items[0].figure->name);
  km_text_add(&text, rows->different ? "." : "");
  if (best >= 0)
    km_text_format(&text, " %s is best in %zu of the %zu figures that have a better side.", names[best], wins, of);
  km_document_lead(k, km_document_words(k, &text, ""));
}

static const char *value_words(km_document_maker *k, const km_compared_row *row, int thing) {
  return km_document_format(k, "%s%s", row->best == thing ? "★ " : "", number_words(k, row->values[thing]));
}

static const char *head_of(km_document_maker *k, const km_compared_figure *figure) {
  return figure->unit[0] ? km_document_format(k, "%s (%s)", figure->name, km_report_unit(k, figure->unit))
                         : figure->name;
}

/* A row for each figure, a column for each thing. */
static void add_figure_rows(km_document_maker *k, const char *const *names, int count, const km_compared_rows *rows) {
  size_t shown = rows->different < MOST_ROWS ? rows->different : MOST_ROWS, columns = (size_t)count + 1;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, (shown + 1) * columns);
  if (!cells)
    return;
  cells[0] = "figure";
  for (int i = 0; i < count; ++i)
    cells[i + 1] = names[i];
  for (size_t r = 0; r < shown; ++r) {
    cells[(r + 1) * columns] = head_of(k, rows->items[r].figure);
    for (int i = 0; i < count; ++i)
      cells[(r + 1) * columns + (size_t)i + 1] = value_words(k, &rows->items[r], i);
  }
  km_document_cells(k, KM_BLOCK_TABLE, cells, shown + 1, columns);
}

/* A row for each thing, a column for each figure. */
static void add_thing_rows(km_document_maker *k, const char *const *names, int count, const char *kind,
                           const km_compared_rows *rows) {
  size_t shown = rows->different < MOST_COLUMNS ? rows->different : MOST_COLUMNS, columns = shown + 1;
  const char **cells = KM_ARENA_NEW(&k->arena, const char *, (size_t)(count + 1) * columns);
  if (!cells)
    return;
  cells[0] = kind;
  for (size_t r = 0; r < shown; ++r)
    cells[r + 1] = head_of(k, rows->items[r].figure);
  for (int i = 0; i < count; ++i) {
    cells[(size_t)(i + 1) * columns] = names[i];
    for (size_t r = 0; r < shown; ++r)
      cells[(size_t)(i + 1) * columns + r + 1] = value_words(k, &rows->items[r], i);
  }
  km_document_cells(k, KM_BLOCK_TABLE, cells, (size_t)count + 1, columns);
}

/* Names and values of the figures that are equal. */
static void add_equal(km_document_maker *k, const km_compared_rows *rows, km_text *out) {
  const size_t equal = rows->count - rows->different;
  for (size_t i = 0; i < equal && i < MOST_EQUAL_NAMED; ++i) {
    const km_compared_row *row = &rows->items[rows->different + i];
    km_text_format(out, "%s%s", i ? "; " : " Equal in all: ", row->figure->name);
    if (isfinite(row->low))
      km_text_format(out, " %s%s", number_words(k, row->low), unit_words(k, row->figure));
  }
  if (equal > MOST_EQUAL_NAMED)
    km_text_format(out, "; and %zu more", equal - MOST_EQUAL_NAMED);
  km_text_add(out, equal ? "." : "");
}

/* The paragraph below the table: its mark, the figures that it leaves out, and those that are equal. */
static void add_notes(km_document_maker *k, const km_compared_rows *rows, size_t shown) {
  km_text text = {0};
  bool marked = false;
  for (size_t r = 0; r < rows->different && r < shown; ++r)
    marked = marked || rows->items[r].best >= 0;
  if (marked)
    km_text_add(&text,
                "★ best value: the least force, acceleration or rate, the greatest transmission angle or margin.");
  if (rows->different > shown)
    km_text_format(&text, " %zu more figure%s.", rows->different - shown,
                   rows->different - shown == 1 ? " differs" : "s differ");
  add_equal(k, rows, &text);
  const char *words = km_document_words(k, &text, NULL);
  if (words)
    km_document_text(k, words[0] == ' ' ? words + 1 : words);
}

void km_comparison_page_add(km_document_maker *k, const char *const *names, int count, const char *kind,
                            const char *kinds, const km_compared_rows *rows) {
  const bool side_by_side = count <= SIDE_BY_SIDE;
  add_lead(k, names, count, kinds, rows);
  if (rows->different == 0)
    return;
  km_document_heading(k, "What differs");
  if (side_by_side)
    add_figure_rows(k, names, count, rows);
  else
    add_thing_rows(k, names, count, kind, rows);
  add_notes(k, rows, side_by_side ? MOST_ROWS : MOST_COLUMNS);
}

size_t km_comparison_columns(const km_compared_rows *rows, const char **columns, size_t most) {
  size_t count = 0;
  for (size_t r = 0; r < rows->different && count < most; ++r) {
    const char *column = rows->items[r].figure->column;
    bool is_new = column != NULL;
    for (size_t i = 0; i < count && is_new; ++i)
      is_new = strcmp(columns[i], column) != 0;
    if (is_new)
      columns[count++] = column;
  }
  return count;
}

/* "acceleration of C (deg/s²)" of the column a.C, "limit margin" of limit_margin, for the axis. */
static const char *column_words(km_document_maker *k, const km_table *t, size_t column) {
  static const char *const prefixes[][2] = {
      {"q.", ""},          {"v.", "velocity of "}, {"a.", "acceleration of "},
      {"f.", "force of "}, {"objective.", ""},     {"transmission.", "transmission angle at "}};
  const char *name = km_table_name(t, column), *unit = km_report_unit(k, km_table_unit(t, column));
  char *words = km_arena_string(&k->arena, name);
  for (char *c = words; c && !strchr(name, '.') && *c; ++c)
    *c = *c == '_' ? ' ' : *c;
  if (strncmp(name, "ma.", 3) == 0)
    return km_document_format(k, unit[0] ? "mechanical advantage (%s)" : "mechanical advantage", unit);
  for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; ++i)
    if (strncmp(name, prefixes[i][0], strlen(prefixes[i][0])) == 0)
      return km_document_format(k, unit[0] ? "%s%s (%s)" : "%s%s", prefixes[i][1], name + strlen(prefixes[i][0]), unit);
  return km_document_format(k, unit[0] ? "%s (%s)" : "%s", words ? words : name, unit);
}

/* Curves of one column, a line for each table that has it. */
static km_plot_panel make_panel(km_document_maker *k, const km_compared_table *tables, int count, bool ordered,
                                const char *column) {
  km_plot_panel panel = {.series_count = 0};
  km_plot_series *series = KM_ARENA_NEW(&k->arena, km_plot_series, (size_t)count);
  for (int i = 0; i < count && series; ++i) {
    const km_table *t = tables[i].table;
    const int found = km_table_find(t, column);
    const size_t rows = km_table_rows(t);
    double *values = KM_ARENA_NEW(&k->arena, double, 2 * rows);
    if (found < 0 || tables[i].x < 0 || !values)
      continue;
    km_table_column(t, (size_t)tables[i].x, values, NULL);
    km_table_column(t, (size_t)found, values + rows, NULL);
    panel.y_label = panel.y_label ? panel.y_label : column_words(k, t, (size_t)found);
    series[panel.series_count++] = (km_plot_series){.name = tables[i].name,
                                                    .x = values,
                                                    .y = values + rows,
                                                    .count = rows,
                                                    .colour = km_palette_compared(i, count, ordered)};
  }
  panel.series = series;
  return panel;
}

void km_comparison_curves_add(km_document_maker *k, const km_compared_table *tables, int count, bool ordered,
                              const km_compared_rows *rows, const char *x_label) {
  const char *columns[MOST_PANELS];
  const size_t shown = km_comparison_columns(rows, columns, MOST_PANELS);
  km_plot_panel *panels = KM_ARENA_NEW(&k->arena, km_plot_panel, shown + 1);
  if (shown == 0 || !panels)
    return;
  for (size_t i = 0; i < shown; ++i)
    panels[i] = make_panel(k, tables, count, ordered, columns[i]);
  const km_plot plot = {.x_label = x_label, .panels = panels, .panel_count = shown, .own_y = true};
  km_document_heading(k, "Curves that differ most");
  km_report_plot(k, &plot, "the curves that differ most, over each other",
                 plot_margin + panel_height * (shown > 1 ? (double)shown : lone_panel));
}
