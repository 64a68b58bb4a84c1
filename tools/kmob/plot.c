/* kmob plot: columns of tables, one over another. */
#include "kmob/kmob.h"

#include "kmech/base.h"
#include "kmech/report.h"

#include <string.h>

enum { MOST_TABLES = 64, MOST_COLUMNS = 64 };

typedef struct options {
  kt_common common;
  kt_texts tables, y, labels, names;
  const char *x, *base, *format, *title, *range;
  kt_formats formats;
} options;

/* Columns to plot of every table. */
typedef struct work {
  const options *options;
  char *y[MOST_COLUMNS]; /* requested names, owned */
  size_t columns;
  km_table *tables[MOST_TABLES]; /* owned */
  char names[MOST_TABLES][256];
  size_t found[MOST_TABLES][MOST_COLUMNS];
  km_plotted_table shown[MOST_TABLES];
  const char *new_names[MOST_COLUMNS];
  km_chart_words words;
} work;

/* The name of a column in the first `length` bytes as written in the file, with or without quotes. The caller frees
 * it. */
static char *name_of(const char *text, size_t length) {
  char *name = KM_NEW(char, length + 1);
  bool quoted = length > 1 && text[0] == '"' && text[length - 1] == '"';
  size_t used = 0;
  for (size_t i = quoted; name && i < length - quoted; ++i) {
    name[used++] = text[i];
    i += quoted && text[i] == '"' && text[i + 1] == '"';
  }
  return name;
}

/* Takes the longest beginning that is a column of the first table, up to a comma; else what \ leaves up to the first
 * one. */
static char *copy_name(const work *w, const char **rest, bool *more) {
  for (size_t length = strlen(*rest); length > 0;) {
    char *name = name_of(*rest, length);
    if (!name || km_csv_find(w->tables[0], name) >= 0) {
      *more = (*rest)[length] == ',';
      *rest += length + *more;
      return name;
    }
    km_free(name);
    while (length > 0 && (*rest)[--length] != ',')
      ;
  }
  kt_piece piece = kt_split(rest, ",");
  *more = piece.separator == ',';
  return piece.text;
}

/* COLUMN,COLUMN of every --y. */
static kt_exit read_columns(work *w) {
  const options *o = w->options;
  for (int i = 0; i < o->y.count; ++i) {
    const char *rest = o->y.items[i];
    for (bool more = true; more;) {
      char *name = copy_name(w, &rest, &more);
      if (!name)
        return KT_NO_MEMORY;
      if (w->columns == MOST_COLUMNS || !*name) {
        km_free(name);
        return kt_usage(&o->common, "--y", o->y.items[i], "names of columns, at most 64");
      }
      w->y[w->columns++] = name;
    }
  }
  return KT_DONE;
}

static kt_exit read_options(options *o) {
  if (o->tables.count > MOST_TABLES)
    return kt_usage(&o->common, "TABLE", "…", "at most 64 tables");
  if (o->y.count == 0)
    return kt_usage(&o->common, "--y", "is missing", "at least one column: --y COLUMN");
  if (kt_is_piped(o->base))
    return kt_usage(&o->common, "-o", "-", "a file's name: pictures don't go to the standard output");
  if (!kt_formats_parse_among(&o->common, o->format ? o->format : "svg", "svg,pdf,png", &o->formats))
    return KT_USAGE;
  return KT_DONE;
}

static kt_exit read_table(work *w, size_t t) {
  const options *o = w->options;
  const char *path = o->tables.items[t], *file = strcmp(path, "-") == 0 ? "standard input" : path;
  km_text text = {0};
  km_error error;
  km_status status = km_file_read(path, &text, &error);
  if (!status)
    status = km_csv_read(&text, file, &w->tables[t], &error);
  km_text_free(&text);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s", error.text);
  kt_base_name(path, w->names[t], sizeof w->names[t]);
  return kt_exit_of(status);
}

/* Says which columns are called nearly so. */
static kt_exit no_column(const work *w, size_t t, const char *option, const char *name) {
  const km_table *table = w->tables[t];
  km_nearest nearest = {.wanted = name};
  char names[KM_NEAREST_TEXT];
  for (size_t c = 0; c < km_table_columns(table); ++c)
    km_nearest_add(&nearest, km_table_name(table, c));
  kt_print_message(&w->options->common, KM_ERROR, "%s %s: %s has no such column; the nearest of its %zu are %s", option,
                   name, w->options->tables.items[t], km_table_columns(table), km_nearest_text(&nearest, names));
  return KT_USAGE;
}

/* The column of table t, which must have the unit that the first table's has. */
static kt_exit find_column(const work *w, size_t t, const char *option, const char *name, size_t in_first,
                           size_t *column) {
  int found = km_csv_find(w->tables[t], name);
  if (found < 0)
    return no_column(w, t, option, name);
  *column = (size_t)found;
  if (t == 0)
    return KT_DONE;
  const char *unit = km_table_unit(w->tables[t], *column), *first = km_table_unit(w->tables[0], in_first);
  if (strcmp(unit, first) == 0)
    return KT_DONE;
  kt_print_message(&w->options->common, KM_ERROR, "%s %s: in %s it is in \"%s\"; expected \"%s\", as in %s", option,
                   name, w->options->tables.items[t], unit, first, w->options->tables.items[0]);
  return KT_USAGE;
}

static kt_exit choose_columns(work *w, size_t t) {
  const char *x = w->options->x ? w->options->x : "s";
  size_t over = 0;
  kt_exit result = find_column(w, t, "--x", x, w->shown[0].x, &over);
  for (size_t c = 0; c < w->columns && result == KT_DONE; ++c)
    result = find_column(w, t, "--y", w->y[c], w->found[0][c], &w->found[t][c]);
  w->shown[t] = (km_plotted_table){w->tables[t], w->names[t], over, w->found[t]};
  return result;
}

/* AXIS=TEXT of every --label. */
static kt_exit read_labels(work *w) {
  const kt_texts *labels = &w->options->labels;
  for (int i = 0; i < labels->count; ++i) {
    const char *text = labels->items[i];
    const bool across = strncmp(text, "x=", 2) == 0;
    if (!across && strncmp(text, "y=", 2) != 0)
      return kt_usage(&w->options->common, "--label", text, "x=TEXT or y=TEXT");
    *(across ? &w->words.x_label : &w->words.y_label) = text + 2;
  }
  return KT_DONE;
}

/* Gives the columns that are drawn and called `column` a name; false if there are none. */
static bool rename_column(work *w, const char *column, const char *name) {
  const int found = km_csv_find(w->tables[0], column);
  bool drawn = false;
  if (found >= 0 && w->shown[0].x == (size_t)found) {
    w->words.x_name = name;
    drawn = true;
  }
  for (size_t c = 0; found >= 0 && c < w->columns; ++c)
    if (w->found[0][c] == (size_t)found) {
      w->new_names[c] = name;
      drawn = true;
    }
  return drawn;
}

/* COLUMN=TEXT of every --name. */
static kt_exit read_names(work *w) {
  const options *o = w->options;
  kt_exit result = KT_DONE;
  for (int i = 0; i < o->names.count && result == KT_DONE; ++i) {
    const char *rest = o->names.items[i];
    kt_piece column = kt_split(&rest, "=");
    if (column.separator != '=' || !rename_column(w, column.text, rest))
      result = kt_usage(&o->common, "--name", o->names.items[i], "COLUMN=TEXT with a column of --x or --y");
    km_free(column.text);
  }
  return result;
}

/* Appends a row; NULL: one without values, which interrupts a curve. */
static bool add_row(km_table *to, const double *row) {
  double *cells = km_table_add_row(to);
  if (cells && row)
    memcpy(cells, row, km_table_columns(to) * sizeof *cells);
  return cells != NULL;
}

/* The rows of a table whose x lies in [from, to], with a gap where others lay between them. NULL when out of memory. */
static km_table *rows_within(const km_table *table, size_t x, double from, double to) {
  km_table *out = km_table_create();
  bool good = out != NULL, gap = false;
  for (size_t c = 0; c < km_table_columns(table) && good; ++c) {
    const char *name = km_table_name(table, c), *unit = km_table_unit(table, c);
    good = (km_table_is_plain(table, c) ? km_table_add_plain_column(out, name, unit)
                                        : km_table_add_column(out, name, unit)) >= 0;
  }
  for (size_t r = 0; r < km_table_rows(table) && good; ++r) {
    const double *row = km_table_row(table, r);
    const bool within = row[x] >= from && row[x] <= to;
    if (within && gap && km_table_rows(out) > 0)
      good = add_row(out, NULL);
    if (within)
      good = good && add_row(out, row);
    gap = !within;
  }
  if (!good) {
    km_table_free(out);
    out = NULL;
  }
  return out;
}

/* Keeps of every table the rows of --range. */
static kt_exit read_range(work *w) {
  const options *o = w->options;
  const char *rest = o->range;
  double ends[2] = {0.0};
  if (!rest)
    return KT_DONE;
  kt_piece from = kt_split(&rest, ":");
  const bool good =
      from.separator == ':' && kt_number(from.text, &ends[0]) && kt_number(rest, &ends[1]) && ends[0] < ends[1];
  km_free(from.text);
  if (!good)
    return kt_usage(&o->common, "--range", o->range, "FROM:TO, two numbers in the unit of --x, the smaller one first");
  for (int t = 0; t < o->tables.count; ++t) {
    km_table *within = rows_within(w->tables[t], w->shown[t].x, ends[0], ends[1]);
    if (!within)
      return KT_NO_MEMORY;
    km_table_free(w->tables[t]);
    w->tables[t] = within;
    w->shown[t].table = within;
    if (km_table_rows(within) == 0) {
      kt_print_message(&o->common, KM_ERROR, "--range %s: %s has no row there; expected a range within its %s",
                       o->range, o->tables.items[t], km_table_name(within, w->shown[t].x));
      return KT_USAGE;
    }
  }
  return KT_DONE;
}

static kt_exit write_plot(const work *w, kt_format format) {
  const options *o = w->options;
  km_text out = {0};
  km_error error;
  km_chart *chart = NULL;
  km_status status = km_table_chart_worded(w->shown, o->tables.count, (int)w->columns, &w->words, &chart, &error);
  if (!status)
    status = km_chart_picture(chart, kt_picture_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s", error.text);
  else
    result = kt_write(&o->common, o->base ? o->base : w->names[0], "plot", kt_format_word(format), &out);
  km_chart_free(chart);
  km_text_free(&out);
  return result;
}

static kt_exit run(work *w) {
  const options *o = w->options;
  kt_exit result = KT_DONE;
  for (int t = 0; t < o->tables.count && result == KT_DONE; ++t)
    result = read_table(w, (size_t)t);
  if (result == KT_DONE)
    result = read_columns(w);
  for (int t = 0; t < o->tables.count && result == KT_DONE; ++t)
    result = choose_columns(w, (size_t)t);
  w->words.title = o->title;
  w->words.names = w->new_names;
  if (result == KT_DONE)
    result = read_labels(w);
  if (result == KT_DONE)
    result = read_names(w);
  if (result == KT_DONE)
    result = read_range(w);
  for (int f = KT_SVG; f <= KT_PNG && result == KT_DONE; ++f)
    if (o->formats.wanted[f])
      result = write_plot(w, (kt_format)f);
  return result;
}

kt_exit kmob_plot(int argc, char **argv) {
  options o = {.common = KT_COMMON("kmob")};
  kt_options all = {.operand = {"table", "TABLE...", true, NULL, &o.tables}};
  const kt_option table[] = {
      {"x", 0, "COLUMN", "The column across (default s), with its unit or without", KT_TEXT, &o.x, KT_ABOUT_MODEL},
      {"y", 0, "COLUMN,…", "The columns upwards (repeatable); those of one unit share an axis", KT_TEXTS, &o.y,
       KT_ABOUT_MODEL},
      {"range", 0, "FROM:TO", "Only the rows whose --x lies there", KT_TEXT, &o.range, KT_ABOUT_MODEL},
      {"title", 0, "TEXT", "The plot's title", KT_TEXT, &o.title, KT_ABOUT_FILES},
      {"label", 0, "AXIS=TEXT", "The label of an axis, x or y", KT_TEXTS, &o.labels, KT_ABOUT_FILES},
      {"name", 0, "COLUMN=TEXT", "What a column is called (repeatable)", KT_TEXTS, &o.names, KT_ABOUT_FILES},
      {"format", 0, "LIST", "Some of svg,pdf,png (default svg)", KT_TEXT_OF("svg or pdf or png"), &o.format,
       KT_ABOUT_FILES},
      KT_BASE(&o.base, "Files are BASE.plot.FORMAT (default: the first table's name)"),
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, 0);
  kt_options_read(&all, "Columns of a CSV table, one over another; of several tables on one page.", argc, argv);
  kt_exit result = read_options(&o);
  work *w = result == KT_DONE ? KM_NEW(work, 1) : NULL;
  if (!w)
    return result == KT_DONE ? KT_NO_MEMORY : result;
  w->options = &o;
  result = run(w);
  for (size_t c = 0; c < w->columns; ++c)
    km_free(w->y[c]);
  for (int t = 0; t < o.tables.count; ++t)
    km_table_free(w->tables[t]);
  km_free(w);
  return result;
}
