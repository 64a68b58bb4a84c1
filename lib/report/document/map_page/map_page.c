/* Page of a map over two drivers: sheets as surfaces that turn.
 *
 * A point of a curve lies on the sheets of the cells c next to it whose configuration is nearest to its own,
 *
 *   |q_c − q|² = Σ (angles modulo a full turn; lengths over the characteristic length)² */
#include "report/document/map_page/map_page.h"
#include "base/arguments.h"
#include "kmech/data.h"
#include "model/model.h"
#include "report/charts/map_axes.h"
#include "report/charts/space_map/space_map_columns.h"
#include "report/document/escape.h"
#include "report/document/film_page.h"
#include "topology/mechanism.h"

#include <math.h>
#include <string.h>

enum { MOST_INTERVALS = 100 }; /* most intervals of an axis; of finer maps the page keeps every k-th grid point */
static const double farthest_sheet = 0.5; /* radians: sheets that meet at a curve differ by less beside it */

typedef struct map_page {
  const km_mechanism *m;
  const km_space_map_def *def;
  const km_space_map *map;
  const km_map_look *look;
  km_map_columns columns;
  km_arena arena;
  int stride, across, down; /* distance of grid points that are kept; their numbers along both drivers */
  size_t *rows;             /* [cells] rows of the cells that are kept */
  int cells;
  int *first, *next; /* [across × down], [cells] cells of each grid point; −1: no further one */
  km_text *out;
} map_page;

/* ---- Cells that are kept. */

/* Index of a value on the axis. */
static double grid_place(const km_space_axis *axis, double value) {
  return (value - axis->from) / (axis->to - axis->from) * axis->steps;
}

/* The kept grid point of a cell; −1: it isn't kept. */
static int kept_point(const map_page *p, const double *row) {
  int at[2];
  for (int d = 0; d < 2; ++d)
    at[d] = (int)round(grid_place(&p->def->axis[d], row[d]));
  bool is_kept = at[0] % p->stride == 0 && at[1] % p->stride == 0;
  return is_kept ? at[1] / p->stride * p->across + at[0] / p->stride : -1;
}

static km_status keep_cells(map_page *p, km_error *error) {
  const km_space_axis *axis = p->def->axis;
  const km_table *t = p->map->cells;
  size_t count = km_table_rows(t);
  int longest = axis[0].steps > axis[1].steps ? axis[0].steps : axis[1].steps;
  p->stride = (longest + MOST_INTERVALS - 1) / MOST_INTERVALS;
  p->across = axis[0].steps / p->stride + 1;
  p->down = axis[1].steps / p->stride + 1;
  size_t points = (size_t)p->across * (size_t)p->down;
  p->rows = KM_ARENA_NEW(&p->arena, size_t, count + 1);
  p->next = KM_ARENA_NEW(&p->arena, int, count + 1);
  p->first = KM_ARENA_NEW(&p->arena, int, points);
  if (p->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the map's page");
  memset(p->first, -1, points * sizeof *p->first);
  for (size_t r = 0; r < count; ++r) {
    int point = kept_point(p, km_table_row(t, r));
    if (point < 0)
      continue;
    p->rows[p->cells] = r;
    p->next[p->cells] = p->first[point];
    p->first[point] = p->cells++;
  }
  if (p->cells == 0)
    return km_fail(error, KM_NO_RESULT,
                   "no sheet has a grid point: the range doesn't contain the pose, or the drivers are singular there");
  return KM_OK;
}

/* ---- Sheets of a curve's points. */

static double configuration_distance(const map_page *p, const double *cell, const double *point) {
  const km_model *model = p->m->model;
  double sum = 0.0, size = km_mechanism_characteristic_length(p->m, NULL);
  km_span q = km_table_span(p->map->curves, "q.");
  for (size_t k = 0; k < q.count; ++k) {
    int c = km_table_find(p->map->cells, km_table_name(p->map->curves, q.first + k));
    double d = cell[c] - point[q.first + k], factor = km_model_coordinate_factor(model, (int)k);
    d = km_model_coordinate_is_length(model, (int)k) ? d / size : remainder(d * factor, 2.0 * M_PI);
    sum += d * d;
  }
  return sqrt(sum);
}

/* The nearest cell beside a point of a curve that isn't on part `but`, and its distance; −1: none. */
static int nearest_cell(const map_page *p, const double *point, double but, double *distance) {
  int best = -1, corner[2];
  *distance = HUGE_VAL;
  for (int d = 0; d < 2; ++d) {
    const km_space_axis *axis = &p->def->axis[d];
    int column = km_table_find(p->map->curves, km_table_name(p->map->cells, (size_t)d));
    corner[d] = (int)floor(grid_place(axis, point[column]) / p->stride);
  }
  for (int j = corner[1] - 1; j <= corner[1] + 2; ++j)
    for (int i = corner[0] - 1; i <= corner[0] + 2; ++i)
      for (int c = i < 0 || j < 0 || i >= p->across || j >= p->down ? -1 : p->first[j * p->across + i]; c >= 0;
           c = p->next[c]) {
        const double *row = km_table_row(p->map->cells, p->rows[c]);
        double part = row[p->columns.part], d = configuration_distance(p, row, point);
        if (part > 0.0 && part != but && d < *distance) {
          *distance = d;
          best = c;
        }
      }
  return best;
}

/* Cells of the sheets, or aspects, on which a point of a curve lies: two meet at a singular curve. */
static void curve_cells(const map_page *p, const double *point, int cells[2]) {
  double nearest, second;
  bool has_two = point[1] == KM_CURVE_INPUT || (p->columns.part == KM_MAP_ASPECT && point[1] == KM_CURVE_OUTPUT);
  cells[0] = nearest_cell(p, point, 0.0, &nearest);
  cells[1] = -1;
  if (has_two && cells[0] >= 0) {
    double part = km_table_row(p->map->cells, p->rows[cells[0]])[p->columns.part];
    int other = nearest_cell(p, point, part, &second);
    cells[1] = second <= nearest + farthest_sheet ? other : -1;
  }
}

/* ---- Data. */

static void add_number(double value, bool is_first, km_text *out) {
  if (isfinite(value))
    km_text_format(out, is_first ? "%.5g" : ",%.5g", value);
  else
    km_text_add(out, is_first ? "null" : ",null");
}

/* A name as a JSON string inside a script element. */
static void add_string(const char *text, km_text *out) {
  km_text_add(out, "\"");
  for (const unsigned char *at = (const unsigned char *)text; *at; ++at)
    km_text_format(out, *at == '"' || *at == '\\' || *at == '<' || *at < ' ' ? "\\u%04x" : "%c", *at);
  km_text_add(out, "\"");
}

static void add_named(const char *name, const char *unit, km_text *out) {
  km_text_add(out, "{\"name\":");
  add_string(name, out);
  km_text_add(out, ",\"unit\":");
  add_string(unit ? unit : "", out);
}

static size_t first_column(const map_page *p) {
  return km_table_span(p->map->cells, "m.").first;
}

/* The columns that can be shown: mobility numbers and all behind them; the chosen one if it is a coordinate. */
static void add_columns(const map_page *p) {
  const km_table *t = p->map->cells;
  size_t first = first_column(p), from = p->columns.value < first ? first - 1 : first;
  km_text_add(p->out, ",\"columns\":[");
  for (size_t k = from; k < km_table_columns(t); ++k) {
    size_t column = k < first ? p->columns.value : k;
    km_text_add(p->out, k > from ? ",\n" : "");
    add_named(km_map_column_name(t, column), km_table_unit(t, column), p->out);
    km_text_add(p->out, ",\"values\":[");
    for (int i = 0; i < p->cells; ++i)
      add_number(km_table_row(t, p->rows[i])[column], i == 0, p->out);
    km_text_add(p->out, "]}");
  }
  km_text_format(p->out, "],\"shown\":%zu", p->columns.value < first ? 0 : p->columns.value - first);
}

/* An axis: the grid of a driver, or a column. */
static void add_axis(const map_page *p, const char *key, int d, size_t column) {
  const km_table *t = p->map->cells;
  const km_space_axis *axis = &p->def->axis[d];
  km_text_format(p->out, "\"%s\":", key);
  add_named(km_map_column_name(t, column), km_table_unit(t, column), p->out);
  if (p->columns.part == KM_MAP_ASPECT) {
    size_t first = first_column(p);
    km_text_format(p->out, ",\"column\":%zu},", column - first + (p->columns.value < first));
    return;
  }
  int kept = axis->steps / p->stride;
  double last = axis->from + (axis->to - axis->from) * kept * p->stride / axis->steps;
  km_text_format(p->out, ",\"from\":%.10g,\"to\":%.10g,\"steps\":%d},", axis->from, last, kept);
}

static void add_cells(const map_page *p) {
  const km_table *t = p->map->cells;
  km_text_format(p->out, "\"across\":%d,\"down\":%d,\"word\":\"%s\",\"grid\":[", p->across, p->down,
                 km_table_name(t, p->columns.part));
  for (int i = 0; i < p->cells; ++i)
    km_text_format(p->out, i ? ",%d" : "%d", kept_point(p, km_table_row(t, p->rows[i])));
  km_text_add(p->out, "],\"part\":[");
  for (int i = 0; i < p->cells; ++i)
    km_text_format(p->out, i ? ",%d" : "%d", (int)km_table_row(t, p->rows[i])[p->columns.part]);
  km_text_add(p->out, "]");
}

static void add_curve_column(const map_page *p, const char *key, size_t column) {
  const km_table *t = p->map->curves;
  km_text_format(p->out, "\"%s\":[", key);
  for (size_t r = 0; r < km_table_rows(t); ++r)
    add_number(km_table_row(t, r)[column], r == 0, p->out);
  km_text_add(p->out, "],\n");
}

static void add_curves(const map_page *p) {
  const km_table *t = p->map->curves;
  size_t rows = km_table_rows(t);
  km_text_add(p->out, ",\n\"curves\":{");
  add_curve_column(p, "curve", 0);
  add_curve_column(p, "kind", 1);
  add_curve_column(p, "x", p->columns.curve_x);
  add_curve_column(p, "y", p->columns.curve_y);
  for (int side = 0; side < 2; ++side) {
    km_text_add(p->out, side == 0 ? "\"cell\":[" : "],\n\"other\":[");
    for (size_t r = 0; r < rows; ++r) {
      int cells[2];
      curve_cells(p, km_table_row(t, r), cells);
      km_text_format(p->out, r ? ",%d" : "%d", cells[side]);
    }
  }
  km_text_add(p->out, "]}");
}

static void add_shades(km_text *out) {
  km_text_add(out, ",\"shades\":[");
  for (int i = 0; i < KM_MAP_SHADES; ++i) {
    km_colour c = km_map_shade(i);
    km_text_format(out, "%s\"#%02x%02x%02x\"", i ? "," : "", (unsigned)lround(255 * c.red),
                   (unsigned)lround(255 * c.green), (unsigned)lround(255 * c.blue));
  }
  km_text_add(out, "]");
}

static void add_data(const map_page *p) {
  km_text_add(p->out, "<script type=\"application/json\" id=\"data\">{");
  add_axis(p, "x", 0, p->columns.x);
  add_axis(p, "y", 1, p->columns.y);
  add_cells(p);
  add_columns(p);
  add_curves(p);
  add_shades(p->out);
  km_text_add(p->out, "}</script>\n");
}

/* ---- The page. */

static void add_head(const char *title, km_text *out) {
  km_text_add(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
                   "content=\"width=device-width, initial-scale=1\">\n<title>");
  km_html_escape(title, out);
  km_text_format(out, "</title>\n<style>\n%s\n%s</style>\n</head>\n<body>\n<h1>", km_film_page_sheet,
                 km_map_page_sheet);
  km_html_escape(title, out);
  km_text_add(out, "</h1>\n");
}

static void add_body(const map_page *p) {
  static const char *const names[] = {[KM_MAP_SHEET] = "Sheets", [KM_MAP_ASPECT] = "Aspects"};
  km_text words = {0};
  km_map_curve_words(p->map->curves, "", &words);
  km_text_format(
      p->out,
      "<div class=\"map\"><div class=\"controls\"><label>Height and colour <select id=\"column\"></select>"
      "</label>\n<fieldset id=\"parts\"><legend>%s</legend></fieldset></div>\n"
      "<canvas id=\"map\" tabindex=\"0\" role=\"img\" aria-label=\"The map\"></canvas>\n"
      "<output id=\"says\"></output>\n<div class=\"colours\"><span id=\"low\"></span><div id=\"scale\" "
      "role=\"img\" aria-label=\"Scale of the colours, dark to light\"></div><span id=\"high\"></span></div>\n"
      "<p class=\"about\">",
      names[p->columns.part]);
  km_html_escape(words.data ? words.data : "", p->out);
  p->out->failed = p->out->failed || words.failed;
  km_text_free(&words);
  if (p->stride > 1)
    km_text_format(p->out, "every %d. grid point of the table · ", p->stride);
  km_text_add(
      p->out,
      "curves are as high as the grid points beside them · values beyond the colours have the height of the ends · drag, arrow keys: turn · wheel, two fingers, "
      "+ and −: zoom · Home: as at first · Shift and arrow keys: move the mark</p></div>\n"
      "<noscript><p>The surfaces need the script of this page.</p></noscript>\n");
}

km_status km_space_map_page(const km_mechanism *mechanism, const km_space_map_def *def, const km_space_map *map,
                            const km_map_look *look, km_text *out, km_error *error) {
  km_status status = km_check_given(out != NULL, "place for the result", error);
  if (!status)
    status = km_check_given(mechanism && def && map && map->cells && map->curves && look, "map or its look", error);
  if (status)
    return status;
  map_page p = {.m = mechanism, .def = def, .map = map, .look = look, .out = out};
  size_t before = out->size;
  status = km_map_columns_choose(def, map, look, &p.columns, error);
  if (!status)
    status = keep_cells(&p, error);
  if (!status) {
    add_head(look->title ? look->title : "Map", out);
    add_body(&p);
    add_data(&p);
    km_text_format(out, "<script>\n%s</script>\n</body>\n</html>\n", km_map_page_script);
  }
  km_arena_free(&p.arena);
  if (out->failed)
    status = km_fail(error, KM_MEMORY, "out of memory for the map's page");
  if (status)
    out->size = before;
  return status;
}
