/* Figures of merit of a table's columns. */
#include "base/check.h"
#include "base/larger.h"
#include "base/table.h"

#include <math.h>

/* Two columns of a table, row by row. */
typedef struct series {
  const double *first; /* row; the others are `width` numbers apart */
  size_t rows, width, s, column;
} series;

static double s_of(const series *f, size_t row) {
  return f->first[row * f->width + f->s];
}

static double value_of(const series *f, size_t row) {
  return f->first[row * f->width + f->column];
}

/* The smallest of sign × value, which skips what is no number; HUGE_VAL: none is smaller. Of two rows at a time, so that one
 * comparison doesn't wait for the other. */
static double least_of(const double *cell, size_t rows, size_t width, double sign) {
  double even = HUGE_VAL, odd = HUGE_VAL;
  for (size_t r = 0; r + 1 < rows; r += 2, cell += 2 * width) {
    even = km_smaller(sign * cell[0], even);
    odd = km_smaller(sign * cell[width], odd);
  }
  if (rows % 2 == 1)
    even = km_smaller(sign * cell[0], even);
  return km_smaller(even, odd);
}

size_t km_table_extreme_row(const km_table *table, size_t column, double sign) {
  size_t rows = km_table_rows(table), width = km_table_columns(table);
  const double *cell = rows > 0 ? km_table_row(table, 0) + column : NULL;
  double extreme = sign * least_of(cell, rows, width, sign);
  size_t r = 0;
  while (r < rows && !(cell[r * width] == extreme))
    ++r;
  return r;
}

/* Over the rows that have a value. */
static double mean(const series *f) {
  size_t last = f->rows;
  double area = 0.0, width = 0.0;
  for (size_t r = 0; r < f->rows; ++r) {
    if (isnan(value_of(f, r)))
      continue;
    if (last < r) {
      area += 0.5 * (value_of(f, last) + value_of(f, r)) * (s_of(f, r) - s_of(f, last));
      width += s_of(f, r) - s_of(f, last);
    }
    last = r;
  }
  if (width != 0.0)
    return area / width;
  return last < f->rows ? value_of(f, last) : nan("");
}

/* On the line through the rows around `at`. */
static double value_at(const series *f, double at) {
  for (size_t r = 0; r < f->rows; ++r) {
    double s = s_of(f, r);
    if (s == at)
      return value_of(f, r);
    if (r == 0 || (s_of(f, r - 1) < at) == (s < at))
      continue;
    double t = (at - s_of(f, r - 1)) / (s - s_of(f, r - 1));
    return (1.0 - t) * value_of(f, r - 1) + t * value_of(f, r);
  }
  return nan("");
}

km_status km_table_figure(const km_table *table, const char *column, km_figure figure, double at, double *value,
                          double *where, km_error *error) {
  km_status status = km_check_given(table && column && value, "table, column or place for the value", error);
  if (status)
    return status;
  int index = km_table_find(table, column), s = km_table_find(table, "s");
  if (index < 0 || s < 0)
    return km_fail(error, KM_USAGE, "there is no column \"%s\"", index < 0 ? column : "s");
  size_t rows = km_table_rows(table);
  series f = {km_table_row(table, 0), rows, km_table_columns(table), (size_t)s, (size_t)index};
  bool wants_low = figure == KM_FIGURE_MIN || figure == KM_FIGURE_SPAN;
  bool wants_high = figure == KM_FIGURE_MAX || figure == KM_FIGURE_SPAN;
  size_t low = wants_low ? km_table_extreme_row(table, f.column, 1.0) : rows;
  size_t high = wants_high ? km_table_extreme_row(table, f.column, -1.0) : rows;
  size_t row = figure == KM_FIGURE_MIN ? low : figure == KM_FIGURE_MAX ? high : rows;
  *value = nan("");
  if (row < rows)
    *value = value_of(&f, row);
  else if (figure == KM_FIGURE_SPAN && low < rows)
    *value = value_of(&f, high) - value_of(&f, low);
  else if (figure == KM_FIGURE_MEAN)
    *value = mean(&f);
  else if (figure == KM_FIGURE_AT)
    *value = value_at(&f, at);
  if (where)
    *where = row < rows ? s_of(&f, row) : figure == KM_FIGURE_AT ? at : nan("");
  return KM_OK;
}
