/* Columns of a map over two drivers that its picture and its page show. */
#include "report/charts/space_map/space_map_columns.h"

#include <math.h>
#include <string.h>

static km_status no_column(const km_table *t, const char *column, km_error *error) {
  km_nearest nearest = {.wanted = column};
  char names[KM_NEAREST_TEXT];
  for (size_t c = 0; c < km_table_columns(t); ++c)
    km_nearest_add(&nearest, km_table_name(t, c));
  return km_fail(error, KM_USAGE, "the map has no column \"%s\"; the nearest are %s", column,
                 km_nearest_text(&nearest, names));
}

/* The chart of a sphere, or the two coordinates of the point's place that vary most, in the order x y z. */
static void choose_places(const km_space_map *map, km_map_columns *c) {
  const km_table *t = map->cells;
  size_t first = km_table_span(t, "point.").first;
  km_span chart = km_table_span(t, "chart.");
  double span[3];
  if (chart.count > 0) {
    c->x = chart.first;
    c->y = chart.first + 1;
    c->curve_x = km_table_span(map->curves, "chart.").first;
    c->curve_y = c->curve_x + 1;
    return;
  }
  for (size_t k = 0; k < 3; ++k) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t r = 0; r < km_table_rows(t); ++r) {
      low = fmin(low, km_table_row(t, r)[first + k]);
      high = fmax(high, km_table_row(t, r)[first + k]);
    }
    span[k] = high - low;
  }
  size_t out = span[2] <= span[0] && span[2] <= span[1] ? 2 : span[0] <= span[1] ? 0 : 1;
  size_t curves = km_table_span(map->curves, "point.").first;
  c->x = first + (out == 0 ? 1 : 0);
  c->y = first + (out == 2 ? 1 : 2);
  c->curve_x = curves + (out == 0 ? 1 : 0);
  c->curve_y = curves + (out == 2 ? 1 : 2);
}

km_status km_map_columns_choose(const km_space_map_def *def, const km_space_map *map, const km_map_look *look,
                                km_map_columns *c, km_error *error) {
  const char *column = look->column ? look->column : "sigma.input";
  int value = km_table_find(map->cells, column);
  if (value < 0)
    return no_column(map->cells, column, error);
  c->value = (size_t)value;
  c->part = look->over_point ? KM_MAP_ASPECT : KM_MAP_SHEET;
  if (look->over_point && !def->has_point)
    return km_fail(error, KM_USAGE, "the map has no point, over whose place it could be drawn");
  if (look->over_point) {
    choose_places(map, c);
    return KM_OK;
  }
  c->x = 0;
  c->y = 1;
  c->curve_x = (size_t)km_table_find(map->curves, km_table_name(map->cells, 0));
  c->curve_y = (size_t)km_table_find(map->curves, km_table_name(map->cells, 1));
  return KM_OK;
}

const char *km_map_column_name(const km_table *cells, size_t column) {
  const char *name = km_table_name(cells, column);
  return strncmp(name, "q.", 2) == 0 ? name + 2 : name;
}

void km_map_curve_words(const km_table *curves, const char *sheets, km_text *out) {
  bool has_curve[KM_CURVE_CLEARANCE + 1] = {false};
  for (size_t r = 0; r < km_table_rows(curves); ++r)
    has_curve[(int)km_table_row(curves, r)[1]] = true;
  if (has_curve[KM_CURVE_INPUT])
    km_text_format(out, "black: the drivers are singular%s · ", sheets);
  km_text_format(out, "%s%s",
                 has_curve[KM_CURVE_OUTPUT] ? "red, dashed: the point can't move in some direction · " : "",
                 has_curve[KM_CURVE_LIMIT] || has_curve[KM_CURVE_CLEARANCE]
                     ? "grey: an end of a range, a limit or the least clearance · "
                     : "");
}
