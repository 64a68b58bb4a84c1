/* Figures of merit of table columns: minimum, maximum, mean, span, interpolated value, root mean square, peak, last
 * value, settling. */
#include "base/arguments.h"
#include "base/extrema.h"
#include "base/table.h"

#include <math.h>

/* Two columns of a table. */
typedef struct series {
  const double *first; /* first row; rows are `width` numbers apart */
  size_t rows, width, s, column;
} series;

static double s_of(const series *f, size_t row) {
  return f->first[row * f->width + f->s];
}

static double value_of(const series *f, size_t row) {
  return f->first[row * f->width + f->column];
}

/* Number of rows that are compared at a time, so that comparisons don't wait for each other; and rows of a block, in
 * which the extreme row is searched again. */
enum { ABREAST = 4, BLOCK_ROWS = 32 };

/* The smallest sign × value, NaN skipped; HUGE_VAL if there is none. */
static double least_of(const double *cell, size_t rows, size_t width, double sign) {
  double least[ABREAST] = {HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
  size_t r = 0;
  for (; r + ABREAST <= rows; r += ABREAST, cell += ABREAST * width)
    for (size_t i = 0; i < ABREAST; ++i)
      least[i] = km_smaller(sign * cell[i * width], least[i]);
  for (; r < rows; ++r, cell += width)
    least[0] = km_smaller(sign * cell[0], least[0]);
  return km_smaller(km_smaller(least[0], least[1]), km_smaller(least[2], least[3]));
}

size_t km_table_extreme_row(const km_table *table, size_t column, double sign) {
  size_t rows = km_table_rows(table), width = km_table_columns(table), block = 0;
  const double *cell = rows > 0 ? km_table_row(table, 0) + column : NULL;
  double extreme = HUGE_VAL;
  for (size_t first = 0; first < rows; first += BLOCK_ROWS) {
    size_t count = rows - first < BLOCK_ROWS ? rows - first : BLOCK_ROWS;
    double least = least_of(cell + first * width, count, width, sign);
    block = least < extreme ? first : block;
    extreme = km_smaller(least, extreme);
  }
  size_t r = block;
  while (r < rows && !(cell[r * width] == sign * extreme))
    ++r;
  return r;
}

/* Mean over the rows that have a value. */
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

/* Linear interpolation between the rows around `at`. */
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

/* sqrt(1/S ∫ y² ds): ∫ y² = (y₀² + y₀ y₁ + y₁²) Δs/3 over an interval where y is linear. */
static double root_mean_square(const series *f) {
  size_t last = f->rows;
  double area = 0.0, width = 0.0;
  for (size_t r = 0; r < f->rows; ++r) {
    double y = value_of(f, r);
    if (isnan(y))
      continue;
    if (last < r) {
      double before = value_of(f, last), step = fabs(s_of(f, r) - s_of(f, last));
      area += (before * before + before * y + y * y) * step / 3.0;
      width += step;
    }
    last = r;
  }
  if (width > 0.0)
    return sqrt(area / width);
  return last < f->rows ? fabs(value_of(f, last)) : nan("");
}

/* The last row with a value; `rows`: none. */
static size_t last_row(const series *f) {
  size_t r = f->rows;
  while (r > 0 && isnan(value_of(f, r - 1)))
    --r;
  return r > 0 ? r - 1 : f->rows;
}

/* Settling: |y − y_last| ≤ fraction · max |y − y_last| from the returned s on. */
static double settling(const series *f, double fraction) {
  size_t last = last_row(f), outside = f->rows;
  if (last == f->rows || !(fraction > 0.0 && fraction < 1.0))
    return nan("");
  double end = value_of(f, last), most = 0.0;
  for (size_t r = 0; r < last; ++r)
    most = fmax(most, fabs(value_of(f, r) - end));
  double bound = fraction * most;
  for (size_t r = 0; r < last; ++r)
    if (fabs(value_of(f, r) - end) > bound)
      outside = r;
  if (outside == f->rows)
    return 0.0;
  size_t inside = outside + 1;
  while (isnan(value_of(f, inside)))
    ++inside;
  double from = fabs(value_of(f, outside) - end), to = fabs(value_of(f, inside) - end);
  double t = (from - bound) / (from - to);
  return (1.0 - t) * s_of(f, outside) + t * s_of(f, inside) - s_of(f, 0);
}

int km_table_variable(const km_table *table) {
  int s = km_table_find(table, "s");
  return s >= 0 ? s : km_table_find(table, "t");
}

/* The row of the figures that are the value of a row; `rows`: another figure, or no value. */
static size_t row_of(const series *f, km_figure figure, size_t low, size_t high) {
  if (figure == KM_FIGURE_PEAK)
    return low < f->rows && fabs(value_of(f, low)) > fabs(value_of(f, high)) ? low : high;
  return figure == KM_FIGURE_MIN    ? low
         : figure == KM_FIGURE_MAX  ? high
         : figure == KM_FIGURE_LAST ? last_row(f)
                                    : f->rows;
}

km_status km_table_figure(const km_table *table, const char *column, km_figure figure, double at, double *value,
                          double *where, km_error *error) {
  km_status status = km_check_given(table && column && value, "table, column or place for the value", error);
  if (status)
    return status;
  int index = km_table_find(table, column), s = km_table_variable(table);
  if (index < 0 || s < 0)
    return km_fail(error, KM_USAGE, "there is no column \"%s\"", index < 0 ? column : "s\" or \"t");
  size_t rows = km_table_rows(table);
  series f = {km_table_row(table, 0), rows, km_table_columns(table), (size_t)s, (size_t)index};
  bool both = figure == KM_FIGURE_SPAN || figure == KM_FIGURE_PEAK;
  size_t low = both || figure == KM_FIGURE_MIN ? km_table_extreme_row(table, f.column, 1.0) : rows;
  size_t high = both || figure == KM_FIGURE_MAX ? km_table_extreme_row(table, f.column, -1.0) : rows;
  size_t row = row_of(&f, figure, low, high);
  *value = nan("");
  if (row < rows)
    *value = figure == KM_FIGURE_PEAK ? fabs(value_of(&f, row)) : value_of(&f, row);
  else if (figure == KM_FIGURE_SPAN && low < rows)
    *value = value_of(&f, high) - value_of(&f, low);
  else if (figure == KM_FIGURE_MEAN)
    *value = mean(&f);
  else if (figure == KM_FIGURE_RMS)
    *value = root_mean_square(&f);
  else if (figure == KM_FIGURE_AT)
    *value = value_at(&f, at);
  else if (figure == KM_FIGURE_SETTLING)
    *value = settling(&f, at);
  if (where)
    *where = row < rows ? s_of(&f, row) : figure == KM_FIGURE_AT ? at : nan("");
  return KM_OK;
}
