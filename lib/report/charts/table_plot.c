/* Plots of any columns of tables: panels by unit, one line a column and table. */
#include "report/charts/table_plot.h"

#include "base/text.h"
#include "model/units.h"
#include "report/plot/axis_ticks.h"
#include "report/plot/short_names.h"

#include <string.h>

enum { MOST_COLOURED = 8, MOST_NAMED = 3 };

typedef struct sheet {
  const km_plotted_table *tables;
  size_t count, columns;
  const km_chart_words *words;
  km_arena *arena;
  const char **names; /* [table] short */
  double **x;         /* [table] */
} sheet;

static const char *store(const sheet *s, km_text *text) {
  const char *kept = text->failed ? NULL : km_arena_string(s->arena, text->data ? text->data : "");
  s->arena->failed = s->arena->failed || text->failed;
  km_text_free(text);
  return kept;
}

static double *values_of(const sheet *s, size_t table, size_t column) {
  const km_table *from = s->tables[table].table;
  double *values = KM_ARENA_NEW(s->arena, double, km_table_rows(from) + 1);
  if (values)
    km_table_column(from, column, values, NULL);
  return values;
}

static const char *table_name_of(const sheet *s, size_t column) {
  return km_table_name(s->tables[0].table, s->tables[0].y[column]);
}

static const char *name_of(const sheet *s, size_t column) {
  const char *own = s->words->names ? s->words->names[column] : NULL;
  return own ? own : table_name_of(s, column);
}

static const char *x_name(const sheet *s) {
  return s->words->x_name ? s->words->x_name : km_table_name(s->tables[0].table, s->tables[0].x);
}

/* Words of the user's, else those that are made. */
static const char *chosen(const sheet *s, const char *words, const char *(*make)(const sheet *)) {
  return words ? km_arena_string(s->arena, words) : make(s);
}

static const char *unit_of(const sheet *s, size_t column) {
  return km_table_unit(s->tables[0].table, s->tables[0].y[column]);
}

/* "q.A, q.B (rad)"; where there are many, only their number. */
static const char *label_of(const sheet *s, const char *unit) {
  km_text text = {0};
  size_t named = 0;
  for (size_t c = 0; c < s->columns; ++c)
    if (strcmp(unit_of(s, c), unit) == 0 && named++ < MOST_NAMED)
      km_text_format(&text, "%s%s", named > 1 ? ", " : "", name_of(s, c));
  if (named > MOST_NAMED)
    km_text_format(&text, " and %zu more", named - MOST_NAMED);
  if (*unit)
    km_text_format(&text, " (%s)", unit);
  return store(s, &text);
}

/* Distinguishing part of a line's name in its panel. */
static const char *line_name(const sheet *s, size_t table, size_t column, size_t panel_columns) {
  km_text text = {0};
  if (panel_columns > 1)
    km_text_add(&text, name_of(s, column));
  if (s->count > 1)
    km_text_format(&text, panel_columns > 1 ? " (%s)" : "%s", s->names[table]);
  return panel_columns > 1 || s->count > 1 ? store(s, &text) : NULL;
}

static void fill_panel(const sheet *s, const char *unit, km_plot_panel *panel) {
  km_plot_series *series = KM_ARENA_NEW(s->arena, km_plot_series, s->columns * s->count);
  size_t together = 0, used = 0;
  for (size_t c = 0; c < s->columns; ++c)
    together += strcmp(unit_of(s, c), unit) == 0;
  for (size_t c = 0; c < s->columns && series; ++c)
    for (size_t t = 0; t < s->count && strcmp(unit_of(s, c), unit) == 0; ++t) {
      if (s->tables[t].y[c] >= km_table_columns(s->tables[t].table))
        continue;
      series[used] = (km_plot_series){.name = line_name(s, t, c, together),
                                      .x = s->x[t],
                                      .y = values_of(s, t, s->tables[t].y[c]),
                                      .count = km_table_rows(s->tables[t].table),
                                      .colour = used < MOST_COLOURED ? (int)used : -1,
                                      .dash = used < MOST_COLOURED ? (int)used : 0};
      ++used;
    }
  *panel = (km_plot_panel){.y_label = label_of(s, unit), .series = series, .series_count = used};
}

static bool is_length(const char *unit) {
  for (const km_unit *known = km_quantity_units(KM_LENGTH); known->word; ++known)
    if (strcmp(known->suffix, unit) == 0)
      return true;
  return false;
}

static bool is_point(const char *name) {
  return strncmp(name, "point.", 6) == 0;
}

/* True if x is monotonic, NaN skipped. */
static bool goes_on(const double *x, size_t count) {
  int direction = 0;
  double last = 0.0;
  bool any = false;
  for (size_t i = 0; i < count; ++i) {
    if (!km_axis_takes(x[i]))
      continue;
    int step = any ? (x[i] > last) - (x[i] < last) : 0;
    if (step && direction && step != direction)
      return false;
    direction = step ? step : direction;
    last = x[i];
    any = true;
  }
  return true;
}

static bool lies_in_plane(const sheet *s) {
  const km_plotted_table *first = &s->tables[0];
  const char *unit = km_table_unit(first->table, first->x);
  bool points = is_point(km_table_name(first->table, first->x)), forth = true;
  if (!is_length(unit))
    return false;
  for (size_t c = 0; c < s->columns; ++c) {
    if (strcmp(unit_of(s, c), unit) != 0)
      return false;
    points = points && is_point(table_name_of(s, c));
  }
  for (size_t t = 0; t < s->count; ++t)
    forth = forth && goes_on(s->x[t], km_table_rows(s->tables[t].table));
  return points || !forth;
}

static const char *title_of(const sheet *s) {
  km_text text = {0};
  for (size_t c = 0; c < s->columns && c < MOST_NAMED; ++c)
    km_text_format(&text, "%s%s", c ? ", " : "", name_of(s, c));
  if (s->columns > MOST_NAMED)
    km_text_format(&text, " and %zu more", s->columns - MOST_NAMED);
  km_text_format(&text, " over %s", x_name(s));
  return store(s, &text);
}

static const char *subtitle_of(const sheet *s) {
  km_text text = {0};
  for (size_t t = 0; t < s->count; ++t) {
    size_t rows = km_table_rows(s->tables[t].table);
    km_text_format(&text, "%s%s · %zu row%s", t ? ", " : "", s->tables[t].name, rows, rows == 1 ? "" : "s");
  }
  return store(s, &text);
}

static const char *x_label(const sheet *s) {
  km_text text = {0};
  const char *unit = km_table_unit(s->tables[0].table, s->tables[0].x);
  km_text_format(&text, *unit ? "%s (%s)" : "%s", x_name(s), unit);
  return store(s, &text);
}

/* One panel a unit, in the order of the columns. */
static size_t make_panels(const sheet *s, km_plot_panel *panels) {
  size_t count = 0;
  for (size_t c = 0; c < s->columns; ++c) {
    bool known = false;
    for (size_t k = 0; k < c; ++k)
      known = known || strcmp(unit_of(s, k), unit_of(s, c)) == 0;
    if (!known)
      fill_panel(s, unit_of(s, c), &panels[count++]);
  }
  return count;
}

bool km_table_plot_make(const km_plotted_table *tables, size_t count, size_t columns, const km_chart_words *words,
                        km_arena *arena, km_plot *out) {
  const km_chart_words none = {0};
  sheet s = {tables, count, columns, words ? words : &none, arena, NULL, KM_ARENA_NEW(arena, double *, count)};
  km_plot_panel *panels = KM_ARENA_NEW(arena, km_plot_panel, columns);
  s.names = km_short_names_of(&tables[0].name, sizeof *tables, (int)count, arena);
  for (size_t t = 0; t < count && !arena->failed; ++t)
    s.x[t] = values_of(&s, t, tables[t].x);
  if (arena->failed)
    return false;
  *out = (km_plot){.title = chosen(&s, s.words->title, title_of),
                   .subtitle = subtitle_of(&s),
                   .x_label = chosen(&s, s.words->x_label, x_label),
                   .panels = panels,
                   .panel_count = make_panels(&s, panels),
                   .own_y = true,
                   .equal = lies_in_plane(&s)};
  if (s.words->y_label)
    panels[0].y_label = km_arena_string(arena, s.words->y_label);
  return !arena->failed;
}
