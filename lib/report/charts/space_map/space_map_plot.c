/* Picture of a map over two drivers: filled contours of a column, a panel for each sheet or aspect, singularity curves
 * on top.
 *
 *   quad of grid points -> triangles;   band b of a triangle: { low_b <= value <= low_b+1 }, value linear in it */
#include "base/arguments.h"
#include "kmech/model.h"
#include "kmech/report.h"
#include "report/canvas/palette.h"
#include "report/charts/map_axes.h"
#include "report/charts/space_map/space_map_columns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PANELS = 6, MOST_QUADS = 80, BAND_CORNERS = 8 };
static const km_colour ink = {0.15, 0.15, 0.15, 1}, grey = {0.40, 0.40, 0.40, 1};
static const double panel_width = 230.0, panel_height = 210.0, margin = 14.0, head = 64.0, gap_x = 58.0, gap_y = 56.0,
                    bar_width = 96.0;
static const double overlap = 0.35;     /* points by which polygons are larger */
static const double longest_quad = 0.2; /* part of the axes: a larger quad is at a singular configuration, or not one */
static const double shortest_line = 1.5;  /* points: shorter ones of a curve are left out */
static const double outlier_share = 0.02; /* share of the values beyond either end of the colours */

/* A corner: place in the panel's units, and value. */
typedef struct corner {
  double x, y, value;
} corner;

typedef struct map_picture {
  const km_mechanism *m;
  const km_space_map_def *def;
  const km_space_map *map;
  const km_map_look *look;
  km_canvas *canvas;
  km_arena arena;
  km_map_columns columns;
  double low, high; /* values at the ends of the colours */
  double x_low, x_high, y_low, y_high;
  int panels, number[MOST_PANELS];
  int across, down, stride; /* grid points along both drivers; distance of those that are drawn */
  int *row;                 /* [across × down] of the present part, −1: not reached */
} map_picture;

/* ---- Choice of columns and ranges. */

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Ranges of the axes, and of the colours: all values but the outliers at both ends. */
static void find_ranges(map_picture *p) {
  const km_table *t = p->map->cells;
  size_t rows = km_table_rows(t), count = 0;
  double *values = KM_ARENA_NEW(&p->arena, double, rows + 1);
  p->x_low = p->y_low = HUGE_VAL;
  p->x_high = p->y_high = -HUGE_VAL;
  for (size_t r = 0; values && r < rows; ++r) {
    const double *row = km_table_row(t, r);
    p->x_low = fmin(p->x_low, row[p->columns.x]);
    p->x_high = fmax(p->x_high, row[p->columns.x]);
    p->y_low = fmin(p->y_low, row[p->columns.y]);
    p->y_high = fmax(p->y_high, row[p->columns.y]);
    if (isfinite(row[p->columns.value]))
      values[count++] = row[p->columns.value];
  }
  if (!values)
    return;
  qsort(values, count, sizeof *values, ascending);
  p->low = count > 0 ? values[(size_t)(outlier_share * (double)(count - 1))] : 0.0;
  p->high = count > 0 ? values[(size_t)((1.0 - outlier_share) * (double)(count - 1))] : 1.0;
  km_axis_widen(&p->low, &p->high);
  km_axis_widen(&p->x_low, &p->x_high);
  km_axis_widen(&p->y_low, &p->y_high);
}

/* A part of the cells, and their number. */
typedef struct map_part {
  int number, cells;
} map_part;

static int by_size(const void *a, const void *b) {
  const map_part *x = a, *y = b;
  return x->cells != y->cells ? (x->cells < y->cells) - (x->cells > y->cells) : x->number - y->number;
}

/* The largest parts, a panel each. */
static void find_panels(map_picture *p) {
  const km_table *t = p->map->cells;
  int count = 0;
  for (size_t r = 0; r < km_table_rows(t); ++r)
    count = (int)fmax(count, km_table_row(t, r)[p->columns.part]);
  map_part *parts = KM_ARENA_NEW(&p->arena, map_part, (size_t)count + 1);
  if (!parts)
    return;
  for (int k = 0; k < count; ++k)
    parts[k].number = k + 1;
  for (size_t r = 0; r < km_table_rows(t); ++r)
    if (km_table_row(t, r)[p->columns.part] > 0.0) /* an aspect's number is 0 on a singularity curve */
      ++parts[(int)km_table_row(t, r)[p->columns.part] - 1].cells;
  qsort(parts, (size_t)count, sizeof *parts, by_size);
  while (p->panels < MOST_PANELS && p->panels < count && parts[p->panels].cells > 0) {
    p->number[p->panels] = parts[p->panels].number;
    ++p->panels;
  }
}

/* ---- Filled contours. */

/* Index of a value's band: below 0 and above the last one are those at the ends. */
static int band_of(const map_picture *p, double value) {
  double part = (value - p->low) / (p->high - p->low) * KM_MAP_SHADES;
  return part <= 0.0 ? 0 : part >= KM_MAP_SHADES ? KM_MAP_SHADES - 1 : (int)part;
}

/* Clips a polygon to value >= level, or to value <= level where `sign` is −1. Returns the number of its corners. */
static int clip(const corner *from, int count, double level, double sign, corner *to) {
  int n = 0;
  for (int i = 0; i < count; ++i) {
    const corner *a = &from[i], *b = &from[(i + 1) % count];
    double u = sign * (a->value - level), v = sign * (b->value - level);
    if (u >= 0.0)
      to[n++] = *a;
    if ((u >= 0.0) != (v >= 0.0)) {
      double part = u / (u - v);
      to[n++] = (corner){a->x + part * (b->x - a->x), a->y + part * (b->y - a->y), level};
    }
  }
  return n;
}

static void fill_polygon(const map_picture *p, const km_frame *frame, const corner *corners, int count, int band) {
  km_canvas_point points[BAND_CORNERS];
  km_canvas_point middle = {0.0, 0.0};
  for (int i = 0; i < count; ++i) {
    points[i] = km_frame_map(frame, corners[i].x, corners[i].y);
    middle.x += points[i].x / count;
    middle.y += points[i].y / count;
  }
  for (int i = 0; i < count; ++i) { /* neighbours overlap, so that no line shows between them */
    double x = points[i].x - middle.x, y = points[i].y - middle.y, distance = hypot(x, y);
    points[i].x += distance > 0.0 ? overlap * x / distance : 0.0;
    points[i].y += distance > 0.0 ? overlap * y / distance : 0.0;
  }
  km_canvas_polygon(p->canvas, km_map_shade(band), points, (size_t)count);
}

static void fill_triangle(const map_picture *p, const km_frame *frame, const corner *t) {
  int first = KM_MAP_SHADES, last = 0;
  for (int i = 0; i < 3; ++i) {
    if (!isfinite(t[i].value))
      return;
    first = band_of(p, t[i].value) < first ? band_of(p, t[i].value) : first;
    last = band_of(p, t[i].value) > last ? band_of(p, t[i].value) : last;
  }
  fill_polygon(p, frame, t, 3, first); /* the whole of it, so that no gap shows between bands */
  for (int band = first + 1; band <= last; ++band) {
    corner upper[BAND_CORNERS];
    int n = clip(t, 3, p->low + (p->high - p->low) * band / KM_MAP_SHADES, 1.0, upper);
    if (n > 2)
      fill_polygon(p, frame, upper, n, band);
  }
}

/* The corner of a grid point; false if the sheet doesn't reach it. */
static bool corner_at(const map_picture *p, int i, int j, corner *out) {
  i = i < p->across ? i : p->across - 1;
  j = j < p->down ? j : p->down - 1;
  int r = p->row[j * p->across + i];
  if (r < 0)
    return false;
  const double *row = km_table_row(p->map->cells, (size_t)r);
  *out = (corner){row[p->columns.x], row[p->columns.y], row[p->columns.value]};
  return true;
}

/* Fills a quad of grid points, or the triangle of the three that are reached. */
static void fill_quad(const map_picture *p, const km_frame *frame, int i, int j) {
  static const int side[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  corner c[4];
  int n = 0;
  for (int k = 0; k < 4; ++k)
    n += corner_at(p, i + side[k][0] * p->stride, j + side[k][1] * p->stride, &c[n]);
  double most = fmax(longest_quad, 3.0 * p->stride / (p->across < p->down ? p->across : p->down));
  for (int k = 1; p->look->over_point && k < n; ++k)
    if (fabs(c[k].x - c[0].x) > most * (p->x_high - p->x_low) || fabs(c[k].y - c[0].y) > most * (p->y_high - p->y_low))
      return;
  if (n < 3)
    return;
  bool is_plain = n == 4 && isfinite(c[0].value);
  for (int k = 1; k < n && is_plain; ++k)
    is_plain = isfinite(c[k].value) && band_of(p, c[k].value) == band_of(p, c[0].value);
  if (is_plain) {
    fill_polygon(p, frame, c, 4, band_of(p, c[0].value));
    return;
  }
  fill_triangle(p, frame, c);
  const corner other[3] = {c[0], c[2], c[n - 1]};
  if (n == 4)
    fill_triangle(p, frame, other);
}

static void index_part(map_picture *p, int number) {
  const km_table *t = p->map->cells;
  for (int k = 0; k < p->across * p->down; ++k)
    p->row[k] = -1;
  for (size_t r = 0; r < km_table_rows(t); ++r) {
    const double *row = km_table_row(t, r);
    int at[2];
    for (int d = 0; d < 2; ++d) {
      const km_space_axis *a = &p->def->axis[d];
      at[d] = (int)round((row[d] - a->from) / (a->to - a->from) * a->steps);
    }
    if (row[p->columns.part] == number)
      p->row[at[1] * p->across + at[0]] = (int)r;
  }
}

/* ---- Curves, axes, colours. */

/* Draws the singularity curves, broken where a hinge passes a full turn. */
static void draw_curves(map_picture *p, const km_frame *frame) {
  const km_table *t = p->map->curves;
  size_t rows = km_table_rows(t), count = 0;
  km_canvas_point *points = KM_ARENA_NEW(&p->arena, km_canvas_point, rows + 1);
  if (!points)
    return;
  for (size_t r = 0; r <= rows; ++r) {
    const double *row = r < rows ? km_table_row(t, r) : NULL, *before = r > 0 ? km_table_row(t, r - 1) : NULL;
    bool is_new =
        !row ||
        (before && (row[0] != before[0] ||
                    fabs(row[p->columns.curve_x] - before[p->columns.curve_x]) > 0.25 * (p->x_high - p->x_low) ||
                    fabs(row[p->columns.curve_y] - before[p->columns.curve_y]) > 0.25 * (p->y_high - p->y_low)));
    if (is_new && count > 1) {
      bool is_output = before[1] == KM_CURVE_OUTPUT,
           is_limit = before[1] == KM_CURVE_LIMIT || before[1] == KM_CURVE_CLEARANCE;
      const double dash[] = {3.0, 2.0};
      const km_pen halo = {.colour = {1, 1, 1, 0.8}, .width = 2.6},
                   pen = {.colour = is_output  ? (km_colour){0.80, 0.10, 0.10, 1}
                                    : is_limit ? grey
                                               : (km_colour){0, 0, 0, 1},
                          .width = 1.2,
                          .dash = is_output ? dash : NULL,
                          .dash_count = is_output ? 2 : 0};
      km_canvas_polyline(p->canvas, &halo, points, count);
      km_canvas_polyline(p->canvas, &pen, points, count);
    }
    count = is_new ? 0 : count;
    if (!row)
      break;
    km_canvas_point at = km_frame_map(frame, row[p->columns.curve_x], row[p->columns.curve_y]);
    bool is_last = r + 1 == rows || km_table_row(t, r + 1)[0] != row[0];
    if (count == 0 || is_last || hypot(at.x - points[count - 1].x, at.y - points[count - 1].y) > shortest_line)
      points[count++] = at;
  }
}

static void axis_name(const map_picture *p, size_t column, km_text *out) {
  const char *unit = km_table_unit(p->map->cells, column);
  km_text_format(out, "%s%s%s%s", km_map_column_name(p->map->cells, column), *unit ? " (" : "", unit, *unit ? ")" : "");
}

static void draw_axes(const map_picture *p, const km_frame *f, int number) {
  const km_font label = {.size = 9}, title = {.size = 9.5, .bold = true};
  double bottom = f->top + f->height;
  km_text x_name = {0}, y_name = {0}, heading = {0};
  axis_name(p, p->columns.x, &x_name);
  axis_name(p, p->columns.y, &y_name);
  km_axis x = km_axis_fit(f->x_low, f->x_high, 5, km_axis_in_degrees(x_name.data), false);
  km_axis y = km_axis_fit(f->y_low, f->y_high, 5, km_axis_in_degrees(y_name.data), false);
  km_map_axes_draw(p->canvas, f, &x, &y, 8, 4);
  km_text_format(&heading, "%s %d", km_table_name(p->map->cells, p->columns.part), number);
  km_canvas_words(p->canvas, &title, ink, &heading, (km_canvas_point){f->left, f->top - 4}, (km_anchor){0, 1, 0});
  km_canvas_words(p->canvas, &label, ink, &x_name, (km_canvas_point){f->left + 0.5 * f->width, bottom + 16},
                  (km_anchor){0.5, 0, 0});
  km_canvas_words(p->canvas, &label, ink, &y_name, (km_canvas_point){f->left - 42, f->top + 0.5 * f->height},
                  (km_anchor){0.5, 0, -acos(0.0)});
}

static void draw_colours(const map_picture *p, double left, double top, double height) {
  const km_font font = {.size = 8.5};
  char multiplier[KM_AXIS_LABEL];
  km_text name = {0};
  km_map_colours_draw(p->canvas, p->low, p->high, left, top, height, multiplier);
  axis_name(p, p->columns.value, &name);
  km_text_format(&name, "%s%s", *multiplier ? " " : "", multiplier);
  km_canvas_words(p->canvas, &font, ink, &name, (km_canvas_point){left, top - 6}, (km_anchor){0, 1, 0});
}

/* ---- The page. */

static km_frame frame_of(const map_picture *p, int panel, int columns) {
  km_frame f = {.left = margin + 46 + (panel % columns) * (panel_width + gap_x),
                .top = margin + head + (panel / columns) * (panel_height + gap_y),
                .width = panel_width,
                .height = panel_height,
                .x_low = p->x_low,
                .x_high = p->x_high,
                .y_low = p->y_low,
                .y_high = p->y_high};
  if (p->look->over_point) { /* equal scales */
    double scale = fmax((f.x_high - f.x_low) / f.width, (f.y_high - f.y_low) / f.height);
    double x = 0.5 * (f.x_low + f.x_high), y = 0.5 * (f.y_low + f.y_high);
    f.x_low = x - 0.5 * scale * f.width;
    f.x_high = x + 0.5 * scale * f.width;
    f.y_low = y - 0.5 * scale * f.height;
    f.y_high = y + 0.5 * scale * f.height;
  }
  return f;
}

static void draw_panel(map_picture *p, int panel, int columns) {
  km_frame frame = frame_of(p, panel, columns);
  index_part(p, p->number[panel]);
  km_canvas_clip(p->canvas, frame.left, frame.top, frame.width, frame.height);
  for (int j = 0; j + 1 < p->down; j += p->stride)
    for (int i = 0; i + 1 < p->across; i += p->stride)
      fill_quad(p, &frame, i, j);
  draw_curves(p, &frame);
  km_canvas_release(p->canvas);
  draw_axes(p, &frame, p->number[panel]);
}

static void draw_page(map_picture *p, int columns, double width) {
  const km_font title = {.size = 13, .bold = true, .width = width - 2 * margin},
                subtitle = {.size = 9, .width = width - 2 * margin, .lines = 2};
  km_text about = {0};
  km_canvas_text(p->canvas, &title, ink, p->look->title ? p->look->title : "Map", (km_canvas_point){margin, margin},
                 (km_anchor){0, 0, 0});
  int parts = p->columns.part == KM_MAP_SHEET ? p->map->sheet_count : p->map->aspect_count;
  km_map_curve_words(p->map->curves, ", on all sheets", &about);
  km_text_format(&about, "values beyond the colours have those of the ends%s",
                 parts > p->panels ? " · further parts are in the table" : "");
  km_canvas_words(p->canvas, &subtitle, grey, &about, (km_canvas_point){margin, margin + 18}, (km_anchor){0, 0, 0});
  for (int panel = 0; panel < p->panels; ++panel)
    draw_panel(p, panel, columns);
  km_frame last = frame_of(p, columns - 1, columns);
  draw_colours(p, last.left + last.width + 16, last.top + 14, 130);
}

static km_status prepare(map_picture *p, km_error *error) {
  km_status status = km_map_columns_choose(p->def, p->map, p->look, &p->columns, error);
  if (status)
    return status;
  find_panels(p);
  if (p->panels == 0)
    return km_fail(error, KM_NO_RESULT,
                   "no sheet has a grid point: the range doesn't contain the pose, or the drivers are singular there");
  find_ranges(p);
  p->across = p->def->axis[0].steps + 1;
  p->down = p->def->axis[1].steps + 1;
  p->stride = 1 + ((p->across > p->down ? p->across : p->down) - 2) / MOST_QUADS;
  p->row = KM_ARENA_NEW(&p->arena, int, (size_t)p->across *(size_t)p->down);
  return p->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the map's picture") : KM_OK;
}

km_status km_space_map_picture(const km_mechanism *mechanism, const km_space_map_def *def, const km_space_map *map,
                               const km_map_look *look, km_picture_format format, km_text *out, km_error *error) {
  km_status status = km_check_picture(out, format, error);
  if (!status)
    status = km_check_given(mechanism && def && map && map->cells && map->curves && look, "map or its look", error);
  if (status)
    return status;
  map_picture p = {.m = mechanism, .def = def, .map = map, .look = look};
  status = prepare(&p, error);
  int columns = p.panels < 2 ? 1 : p.panels < 5 ? 2 : 3, rows = p.panels > 0 ? (p.panels + columns - 1) / columns : 1;
  double width = 2 * margin + 46 + columns * panel_width + (columns - 1) * gap_x + bar_width;
  if (!status)
    status =
        km_canvas_create(format, width, 2 * margin + head + rows * (panel_height + gap_y) - 16, out, &p.canvas, error);
  if (!status) {
    draw_page(&p, columns, width);
    status = p.arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the map's picture")
                            : km_canvas_finish(p.canvas, error);
  }
  km_canvas_free(p.canvas);
  km_arena_free(&p.arena);
  return status;
}
