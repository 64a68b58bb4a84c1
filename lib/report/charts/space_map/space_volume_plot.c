/* Picture of a workspace whose size was found by samples: its views along three axes, or in its plane.
 *
 *   bin of a view : b × b columns of cells along the line of sight, N samples in all, of which n are reached
 *   colour        : depth of the workspace there, extent · n / N;  in a plane the share n / N
 *   The sum of depth · area over the bins of each view is the volume. */
#include "base/arguments.h"
#include "base/table.h"
#include "report/charts/map_axes.h"

#include <math.h>
#include <string.h>

enum { MOST_BINS = 80 /* bins along an axis: 1 mm on paper */ };
static const km_colour ink = {0.15, 0.15, 0.15, 1}, grey = {0.40, 0.40, 0.40, 1};
static const double margin = 14.0, axis_room = 46.0, head = 70.0, gap_x = 62.0, gap_y = 60.0, bar_room = 150.0,
                    bar_height = 110.0;
static const double tick_distance = 35.0;                     /* points: labels of five digits don't touch */
static const double seam = 0.3;                               /* points by which rectangles overlap */
static const double side_length = 220.0, least_length = 70.0; /* points: the longest axis, and two ticks' */

typedef struct volume_picture {
  const km_space_volume *v;
  const char *title;
  km_canvas *canvas;
  km_arena arena;
  bool is_stretched; /* an axis has another scale than the others */
  double length[3];  /* points */
  int stride[3];     /* cells of a bin along each axis */
  int bins[3];
  int *reached, *samples; /* [MOST_BINS²] of the present view's bins */
  double deepest;
} volume_picture;

/* Axes of a view; that of the line of sight is −1 in a plane. */
typedef struct view {
  int across, up, along;
} view;

/* The views at the upper left, the upper right and the lower left of the page. */
static const view views[] = {{0, 2, 1}, {1, 2, 0}, {0, 1, 2}};

static view view_of(const volume_picture *p, int number) {
  return p->v->dimension == 3 ? views[number] : (view){0, 1, -1};
}

static int view_count(const volume_picture *p) {
  return p->v->dimension == 3 ? 3 : 1;
}

static double extent(const volume_picture *p, int axis) {
  return p->v->box_high[axis] - p->v->box_low[axis];
}

/* ---- Bins. */

/* Index of a sample's bin along an axis: samples are in the order of cells, the first axis fastest, two in each. */
static int bin_of(const volume_picture *p, int sample, int axis) {
  int cell = sample / 2;
  for (int k = 0; k < axis; ++k)
    cell /= p->v->cells[k];
  return cell % p->v->cells[axis] / p->stride[axis];
}

static void count_bins(volume_picture *p, view w) {
  memset(p->reached, 0, MOST_BINS * MOST_BINS * sizeof *p->reached);
  memset(p->samples, 0, MOST_BINS * MOST_BINS * sizeof *p->samples);
  for (int i = 0; i < p->v->samples; ++i) {
    int bin = bin_of(p, i, w.up) * MOST_BINS + bin_of(p, i, w.across);
    ++p->samples[bin];
    p->reached[bin] += km_table_row(p->v->points, (size_t)i)[3] == 1.0;
  }
}

static double depth_at(const volume_picture *p, view w, int i, int j) {
  int bin = j * MOST_BINS + i;
  return (w.along < 0 ? 1.0 : extent(p, w.along)) * p->reached[bin] / p->samples[bin];
}

static void find_deepest(volume_picture *p) {
  for (int n = 0; n < view_count(p); ++n) {
    view w = view_of(p, n);
    count_bins(p, w);
    for (int j = 0; j < p->bins[w.up]; ++j)
      for (int i = 0; i < p->bins[w.across]; ++i)
        p->deepest = fmax(p->deepest, depth_at(p, w, i, j));
  }
  p->deepest = p->deepest > 0.0 ? p->deepest : 1.0;
}

/* ---- Views. */

/* The place of an axis's end of a bin. */
static double bin_end(const volume_picture *p, int axis, int bin) {
  int cell = bin * p->stride[axis] < p->v->cells[axis] ? bin * p->stride[axis] : p->v->cells[axis];
  return p->v->box_low[axis] + extent(p, axis) * cell / p->v->cells[axis];
}

static void fill_bin(const volume_picture *p, const km_frame *f, view w, int i, int j) {
  double depth = depth_at(p, w, i, j);
  int shade = (int)(depth / p->deepest * KM_MAP_SHADES);
  km_canvas_point low = km_frame_map(f, bin_end(p, w.across, i), bin_end(p, w.up, j)),
                  high = km_frame_map(f, bin_end(p, w.across, i + 1), bin_end(p, w.up, j + 1));
  if (depth > 0.0)
    km_canvas_rectangle(p->canvas, km_map_shade(shade < KM_MAP_SHADES ? shade : KM_MAP_SHADES - 1), low.x, high.y,
                        high.x - low.x + seam, low.y - high.y + seam);
}

static km_frame frame_of(const volume_picture *p, view w) {
  return (km_frame){.left = margin + axis_room + (w.across == 1 ? p->length[0] + gap_x : 0.0),
                    .top = margin + head + (w.along == 2 ? p->length[2] + gap_y : 0.0),
                    .width = p->length[w.across],
                    .height = p->length[w.up],
                    .x_low = p->v->box_low[w.across],
                    .x_high = p->v->box_high[w.across],
                    .y_low = p->v->box_low[w.up],
                    .y_high = p->v->box_high[w.up]};
}

/* "x (mm)" */
static void name_axis(const volume_picture *p, int axis, km_text *out) {
  km_space_volume_axis_text(p->v, axis, out);
  km_text_format(out, " (%s)", km_table_unit(p->v->points, 0));
}

static size_t most_ticks(double length) {
  return (size_t)(length / tick_distance);
}

static void draw_axes(const volume_picture *p, const km_frame *f, view w) {
  const km_font label = {.size = 9}, heading = {.size = 9.5, .bold = true};
  km_text across = {0}, up = {0}, sight = {0};
  km_axis x = km_axis_fit(f->x_low, f->x_high, most_ticks(f->width), false, false);
  km_axis y = km_axis_fit(f->y_low, f->y_high, most_ticks(f->height), false, false);
  km_map_axes_draw(p->canvas, f, &x, &y, 8, 4);
  name_axis(p, w.across, &across);
  name_axis(p, w.up, &up);
  km_canvas_words(p->canvas, &label, ink, &across, (km_canvas_point){f->left + 0.5 * f->width, f->top + f->height + 16},
                  (km_anchor){0.5, 0, 0});
  km_canvas_words(p->canvas, &label, ink, &up, (km_canvas_point){f->left - 42, f->top + 0.5 * f->height},
                  (km_anchor){0.5, 0, -acos(0.0)});
  if (w.along < 0)
    return;
  km_text_add(&sight, "seen along ");
  km_space_volume_axis_text(p->v, w.along, &sight);
  km_canvas_words(p->canvas, &heading, ink, &sight, (km_canvas_point){f->left, f->top - 4}, (km_anchor){0, 1, 0});
}

static void draw_view(volume_picture *p, view w) {
  km_frame frame = frame_of(p, w);
  count_bins(p, w);
  for (int j = 0; j < p->bins[w.up]; ++j)
    for (int i = 0; i < p->bins[w.across]; ++i)
      fill_bin(p, &frame, w, i, j);
  draw_axes(p, &frame, w);
}

/* ---- The page. */

/* The bar's place: right of a plane, else below the second view. */
static km_canvas_point bar_place(const volume_picture *p) {
  km_canvas_point at = {margin + axis_room + p->length[0] + gap_x, margin + head + 14.0};
  return p->v->dimension == 3 ? (km_canvas_point){at.x, at.y + p->length[2] + gap_y}
                              : (km_canvas_point){at.x - 0.5 * gap_x, at.y};
}

static void draw_colours(const volume_picture *p) {
  const km_font font = {.size = 8.5};
  char multiplier[KM_AXIS_LABEL];
  km_canvas_point at = bar_place(p);
  km_text name = {0};
  km_map_colours_draw(p->canvas, 0.0, p->deepest, at.x, at.y, bar_height, multiplier);
  if (p->v->dimension == 3)
    km_text_format(&name, "depth of the workspace (%s%s%s)", multiplier, *multiplier ? " " : "",
                   km_table_unit(p->v->points, 0));
  else
    km_text_add(&name, "share of samples reached");
  km_canvas_words(p->canvas, &font, ink, &name, (km_canvas_point){at.x, at.y - 6}, (km_anchor){0, 1, 0});
}

static void draw_page(volume_picture *p, double width) {
  const km_font title = {.size = 13, .bold = true, .width = width - 2 * margin},
                size = {.size = 10, .bold = true, .width = width - 2 * margin, .lines = 2},
                subtitle = {.size = 9, .width = width - 2 * margin};
  km_text result = {0}, about = {0};
  km_canvas_text(p->canvas, &title, ink, p->title ? p->title : "Workspace", (km_canvas_point){margin, margin},
                 (km_anchor){0, 0, 0});
  km_space_volume_text(p->v, &result);
  double below = margin + 20.0 + (result.data ? km_canvas_measure(p->canvas, &size, result.data).y : 0.0);
  km_canvas_words(p->canvas, &size, ink, &result, (km_canvas_point){margin, margin + 18}, (km_anchor){0, 0, 0});
  km_text_format(&about, "%d samples, %d reached · white: none reached%s", p->v->samples, p->v->reached,
                 p->is_stretched ? " · axes have different scales" : "");
  km_canvas_words(p->canvas, &subtitle, grey, &about, (km_canvas_point){margin, below}, (km_anchor){0, 0, 0});
  for (int n = 0; n < view_count(p); ++n)
    draw_view(p, view_of(p, n));
  draw_colours(p);
}

/* One scale for all axes, but for those that would be too short for their labels. */
static void choose_lengths(volume_picture *p) {
  double longest = 0.0;
  for (int k = 0; k < p->v->dimension; ++k)
    longest = fmax(longest, extent(p, k));
  for (int k = 0; k < p->v->dimension; ++k) {
    double length = side_length * extent(p, k) / longest;
    p->is_stretched = p->is_stretched || length < least_length;
    p->length[k] = fmax(length, least_length);
    p->stride[k] = 1 + (p->v->cells[k] - 1) / MOST_BINS;
    p->bins[k] = (p->v->cells[k] + p->stride[k] - 1) / p->stride[k];
  }
}

static km_status draw(volume_picture *p, km_picture_format format, km_text *out, km_error *error) {
  p->reached = KM_ARENA_NEW(&p->arena, int, MOST_BINS *MOST_BINS);
  p->samples = KM_ARENA_NEW(&p->arena, int, MOST_BINS *MOST_BINS);
  if (p->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the workspace's picture");
  choose_lengths(p);
  find_deepest(p);
  bool is_space = p->v->dimension == 3;
  double right = is_space ? gap_x + fmax(p->length[1], bar_room) : bar_room + 0.5 * gap_x;
  double down =
      is_space ? p->length[2] + gap_y + fmax(p->length[1], bar_height + 14.0) : fmax(p->length[1], bar_height + 14.0);
  double width = 2 * margin + axis_room + p->length[0] + right;
  km_status status = km_canvas_create(format, width, 2 * margin + head + down + 30.0, out, &p->canvas, error);
  if (status)
    return status;
  draw_page(p, width);
  return km_canvas_finish(p->canvas, error);
}

km_status km_space_volume_picture(const km_space_volume *volume, const char *title, km_picture_format format,
                                  km_text *out, km_error *error) {
  km_status status = km_check_picture(out, format, error);
  if (!status)
    status = km_check_given(volume && volume->points && volume->samples > 0 &&
                                km_table_rows(volume->points) == (size_t)volume->samples,
                            "volume with its samples", error);
  if (status)
    return status;
  volume_picture p = {.v = volume, .title = title};
  status = draw(&p, format, out, error);
  km_canvas_free(p.canvas);
  km_arena_free(&p.arena);
  return status;
}
