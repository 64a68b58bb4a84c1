/* Layout of a plot's page: panels with space for ticks, names and marks. */
#include "report/plot/plot_layout.h"

#include <float.h>
#include <math.h>

static const double frame_least = 20; /* points: less shows nothing */

typedef struct plot_range {
  double low, high;
} plot_range;

static void take(plot_range *range, double value) {
  if (!km_axis_takes(value))
    return;
  range->low = fmin(range->low, value);
  range->high = fmax(range->high, value);
}

static void copy_series(plot_range *x, plot_range *y, const km_plot_series *series) {
  for (size_t i = 0; i < series->count; i++) {
    if (!km_axis_takes(series->x[i]) || !km_axis_takes(series->y[i]))
      continue;
    take(x, series->x[i]);
    take(y, series->y[i]);
    if (series->base)
      take(y, series->base[i]);
  }
}

/* The y ranges are one a panel. */
static void find_ranges(const km_plot *plot, plot_range *x, plot_range *y) {
  plot_range all = {DBL_MAX, -DBL_MAX};
  *x = all;
  for (size_t p = 0; p < plot->panel_count; p++) {
    const km_plot_panel *panel = &plot->panels[p];
    y[p] = (plot_range){DBL_MAX, -DBL_MAX};
    for (size_t s = 0; s < panel->series_count; s++)
      copy_series(x, &y[p], &panel->series[s]);
    for (size_t m = 0; m < panel->mark_count; m++)
      take(x, panel->marks[m].x);
    all.low = fmin(all.low, y[p].low);
    all.high = fmax(all.high, y[p].high);
  }
  for (size_t p = 0; p < plot->panel_count; p++) {
    y[p] = plot->own_y ? y[p] : all;
    km_axis_widen(&y[p].low, &y[p].high);
  }
  km_axis_widen(&x->low, &x->high);
}

static size_t columns_by_count(size_t panels) {
  return panels <= 3 ? (panels ? panels : 1) : panels == 4 ? 2 : panels <= 9 ? 3 : 4;
}

/* Height at which a plot with equal scales fills its width, within bounds. */
static double height_of_equal(const km_plot *plot, double width) {
  const double beside = 110, above_below = 90, least = 220, most = 640;
  plot_range x, y = {0, 1};
  if (plot->panel_count == 1)
    find_ranges(plot, &x, &y);
  double shape = plot->panel_count == 1 ? (y.high - y.low) / (x.high - x.low) : 1;
  return fmin(fmax((width - beside) * shape + above_below, least), most);
}

void km_plot_layout_size(const km_plot *plot, double *width, double *height) {
  const double single_width = 504, single_height = 324;
  size_t columns = plot->own_y ? 1 : columns_by_count(plot->panel_count);
  size_t rows = plot->panel_count ? (plot->panel_count + columns - 1) / columns : 1;
  double natural = rows == 1 && columns == 1 ? single_height : 90 + 165 * (double)rows;
  *width = plot->width > 0 ? plot->width : columns == 1 ? single_width : 24 + 240 * (double)columns;
  *height = plot->height > 0 ? plot->height : plot->equal ? height_of_equal(plot, *width) : natural;
}

/* The grid whose frames come nearest to a plot's best shape, with few cells left empty. */
static void choose_grid(km_plot_layout *layout, double height) {
  const double best_shape = 1.45, emptiness = 0.4;
  /* Usual height and width of names and ticks in a cell. */
  double beside = 4.5 * layout->tick.size, above_below = 5.5 * layout->tick.size;
  size_t panels = layout->plot->panel_count ? layout->plot->panel_count : 1;
  double least = DBL_MAX;
  for (size_t columns = 1; columns <= (layout->plot->own_y ? 1 : panels); columns++) {
    size_t rows = (panels + columns - 1) / columns;
    double across = fmax(layout->width / (double)columns - beside, 1);
    double down = fmax(height / (double)rows - above_below, 1);
    double cost = fabs(log(across / down / best_shape)) + emptiness * (double)(rows * columns - panels);
    if (cost < least) {
      least = cost;
      layout->columns = columns;
      layout->rows = rows;
    }
  }
}

/* Print keeps its letters' size; only small pages shrink them a little, posters enlarge them. */
static void choose_fonts(km_plot_layout *layout) {
  double size = sqrt(fmin(layout->width / 504, layout->height / 324));
  double scale = layout->scale = fmin(fmax(size, 0.85), 1.5);
  layout->margin = 9 * scale;
  double inner = layout->width - 2 * layout->margin;
  layout->title = (km_font){.size = 11 * scale, .bold = true, .width = inner, .lines = 2};
  layout->subtitle = (km_font){.size = 8 * scale, .width = inner, .lines = 2};
  layout->heading = (km_font){.size = 8.5 * scale, .bold = true};
  layout->label = (km_font){.size = 8.5 * scale};
  layout->tick = (km_font){.size = 7.5 * scale};
  layout->name = (km_font){.size = 8 * scale};
  layout->mark = (km_font){.size = 7 * scale};
}

static double text_height(const km_plot_layout *layout, const km_font *font, const char *text) {
  return text && *text ? km_canvas_measure(layout->canvas, font, text).y : 0;
}

static double widest_tick(const km_plot_layout *layout, const km_axis *axis) {
  char text[KM_AXIS_LABEL];
  double widest = 0;
  for (size_t i = 0; i < axis->count; i++) {
    km_axis_label(axis, i, text);
    widest = fmax(widest, km_canvas_measure(layout->canvas, &layout->tick, text).x);
  }
  return widest;
}

/* Number of ticks whose labels fit. */
static void fit_x(km_plot_layout *layout, plot_range x) {
  double clearance = 1.5 * layout->tick.size;
  for (size_t most = 10; most > 0; most--) {
    layout->x = km_axis_fit(x.low, x.high, most, km_axis_in_degrees(layout->plot->x_label), false);
    double step = layout->frame_width / (layout->x.high - layout->x.low) *
                  (km_axis_tick(&layout->x, 1) - km_axis_tick(&layout->x, 0));
    if (layout->x.count < 2 || widest_tick(layout, &layout->x) + clearance <= step)
      return;
  }
}

static size_t most_y_ticks(const km_plot_layout *layout, double frame_height) {
  return (size_t)fmax(1, fmin(8, frame_height / (2.6 * layout->tick.size)));
}

static bool y_in_degrees(const km_plot *plot, size_t panel) {
  return km_axis_in_degrees(plot->own_y ? plot->panels[panel].y_label : plot->y_label);
}

static void fit_y(km_plot_layout *layout, const plot_range *y, double frame_height) {
  const km_plot *plot = layout->plot;
  size_t most = most_y_ticks(layout, frame_height);
  for (size_t p = 0; p < plot->panel_count; p++) {
    double low = plot->own_y ? plot->panels[p].y_low : plot->y_low;
    double high = plot->own_y ? plot->panels[p].y_high : plot->y_high;
    bool given = low < high && km_axis_takes(low) && km_axis_takes(high);
    layout->y[p] = given ? km_axis_fit(low, high, most, y_in_degrees(plot, p), false)
                         : km_axis_fit(y[p].low, y[p].high, most, y_in_degrees(plot, p), !plot->equal);
  }
}

static bool has_y_multiplier(const km_plot_layout *layout) {
  for (size_t p = 0; p < layout->plot->panel_count; p++)
    if (layout->y[p].multiplier)
      return true;
  return false;
}

static void measure_axes(km_plot_layout *layout) {
  const km_plot *plot = layout->plot;
  char multiplier[KM_AXIS_LABEL];
  double ticks = 0, label = text_height(layout, &layout->label, plot->y_label);
  for (size_t p = 0; p < plot->panel_count; p++) {
    km_axis_multiplier(&layout->y[p], multiplier);
    ticks = fmax(ticks, widest_tick(layout, &layout->y[p]));
    ticks = fmax(ticks, km_canvas_measure(layout->canvas, &layout->tick, multiplier).x);
    if (plot->own_y)
      label = fmax(label, text_height(layout, &layout->label, plot->panels[p].y_label));
  }
  layout->axis_left = ticks + 5 + (label > 0 ? label + 3 : 0);
  layout->left = layout->columns > 1 ? 1.2 * layout->tick.size : 0;
  km_axis_multiplier(&layout->x, multiplier);
  layout->axis_bottom =
      fmax(text_height(layout, &layout->label, plot->x_label), text_height(layout, &layout->tick, multiplier));
}

/* Frame and right side together, before the right side is known. */
static double cell_width(const km_plot_layout *layout) {
  double inner = layout->width - 2 * layout->margin - layout->axis_left;
  return inner / (double)layout->columns - layout->left;
}

static void measure_right(km_plot_layout *layout) {
  double cell = cell_width(layout);
  layout->name.width = fmin(13 * layout->name.size, 0.4 * cell);
  layout->mark.width = fmin(15 * layout->mark.size, 0.4 * cell);
  layout->right = 1.2 * layout->tick.size;
  for (size_t p = 0; p < layout->plot->panel_count; p++) {
    const km_plot_panel *panel = &layout->plot->panels[p];
    layout->right = fmax(layout->right, km_plot_names_room(layout, panel));
    layout->right = fmax(layout->right, km_plot_flags_room(layout, panel, cell));
  }
  layout->frame_width = fmax(cell - layout->right, frame_least);
  layout->heading.width = cell;
}

static void measure_rows(km_plot_layout *layout) {
  const km_plot *plot = layout->plot;
  size_t rows = 0;
  bool marked = false;
  layout->heading_height = 0;
  for (size_t p = 0; p < plot->panel_count; p++) {
    double height = text_height(layout, &layout->heading, plot->panels[p].title);
    layout->heading_height = fmax(layout->heading_height, height > 0 ? height + 2 : 0);
    layout->flags[p] = km_plot_flags_make(layout, &plot->panels[p], layout->frame_width);
    rows = layout->flags[p].rows > rows ? layout->flags[p].rows : rows;
    marked = marked || plot->panels[p].mark_count > 0;
  }
  double row = text_height(layout, &layout->mark, "x");
  layout->head = layout->heading_height + (rows ? (double)rows * row + 3 : 0);
  /* Half of the top tick's label is above the frame, the multiplier's label is above that. */
  layout->head = fmax(layout->head, (has_y_multiplier(layout) ? 2 : 0.7) * layout->tick.size);
  layout->mark_room = marked ? 0.75 * layout->tick.size : 0;
  layout->foot = layout->mark_room + 3 + 1.3 * layout->tick.size;
}

/* Widens a range about its middle. */
static plot_range widened(double low, double high, double size) {
  double middle = 0.5 * (low + high);
  return (plot_range){middle - 0.5 * size, middle + 0.5 * size};
}

/* Equal scales: widens the range of the axis with free space, so that a unit has the same length along x and y. */
static void make_equal(km_plot_layout *layout, plot_range x, const plot_range *y) {
  const double seam = 1.06; /* margin between curve and frame */
  double unit = seam * (x.high - x.low) / layout->frame_width;
  for (size_t p = 0; p < layout->plot->panel_count; p++)
    unit = fmax(unit, seam * (y[p].high - y[p].low) / layout->frame_height);
  fit_x(layout, widened(x.low, x.high, unit * layout->frame_width));
  for (size_t p = 0; p < layout->plot->panel_count; p++) {
    plot_range shown = widened(y[p].low, y[p].high, unit * layout->frame_height);
    layout->y[p] = km_axis_fit(shown.low, shown.high, most_y_ticks(layout, layout->frame_height),
                               y_in_degrees(layout->plot, p), false);
  }
}

/* Frames of the size that the axes leave. */
static void fit_frames(km_plot_layout *layout, plot_range x, double grid_height) {
  measure_axes(layout);
  measure_right(layout);
  fit_x(layout, x);
  measure_rows(layout);
  double row = (grid_height - layout->axis_bottom) / (double)layout->rows;
  layout->frame_height = row - layout->head - layout->foot;
  layout->fits = layout->frame_height >= frame_least && cell_width(layout) > layout->right + frame_least;
}

void km_plot_layout_make(km_plot_layout *layout, double width, double height) {
  const km_plot *plot = layout->plot;
  layout->width = width;
  layout->height = height;
  layout->flags = KM_ARENA_NEW(layout->arena, km_plot_flags, plot->panel_count + 1);
  layout->y = KM_ARENA_NEW(layout->arena, km_axis, plot->panel_count + 1);
  plot_range *y = KM_ARENA_NEW(layout->arena, plot_range, plot->panel_count + 1), x;
  if (layout->arena->failed)
    return;
  choose_fonts(layout);
  double title = text_height(layout, &layout->title, plot->title);
  double subtitle = text_height(layout, &layout->subtitle, plot->subtitle);
  layout->grid_top = layout->margin + title + subtitle + (title + subtitle > 0 ? 6 : 0);
  double grid_height = height - layout->grid_top - layout->margin;
  choose_grid(layout, grid_height);
  find_ranges(plot, &x, y);
  fit_y(layout, y, 0.7 * grid_height / (double)layout->rows);
  layout->x = km_axis_fit(x.low, x.high, 5, false, false); /* its range is all that is needed for now */
  fit_frames(layout, x, grid_height);
  for (int pass = 0; pass < 2 && plot->equal && layout->fits; pass++) { /* the ticks' labels change the frames' size */
    make_equal(layout, x, y);
    if (pass == 0)
      fit_frames(layout, x, grid_height);
  }
}

km_frame km_plot_layout_frame(const km_plot_layout *layout, size_t panel) {
  size_t column = panel % layout->columns, row = panel / layout->columns;
  double across = layout->left + layout->frame_width + layout->right;
  double down = layout->head + layout->frame_height + layout->foot;
  return (km_frame){
      .left = layout->margin + layout->axis_left + layout->left + (double)column * across,
      .top = layout->grid_top + layout->head + (double)row * down,
      .width = layout->frame_width,
      .height = layout->frame_height,
      .x_low = layout->x.low,
      .x_high = layout->x.high,
      .y_low = layout->y[panel].low,
      .y_high = layout->y[panel].high,
  };
}
