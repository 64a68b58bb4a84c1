/* Names of lines at their ends: beside the frame for lines that reach its right border, inside it,
 * where they hide least, for lines that stop early. */
#include "report/canvas/palette.h"
#include "report/plot/plot_layout.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double spacing = 1.1;     /* distance of rows of names, in font sizes */
static const double size_least = 4.5;  /* points: crowded names shrink to this, no further */
static const double lead = 12;         /* length of a leader from a line's end to its name */
static const double lead_straight = 4; /* all names at the height of their lines */
static const double same_place = 6;    /* ends closer than this across share a column of names */
static const double moved = 1.5;       /* a name farther from its line than this gets a leader */

typedef struct line_name {
  const km_plot_series *series;
  const km_curve *curve;
  double width; /* width of the text */
  bool beside;  /* true: in the column right of the frame */
  bool placed;
  double top, left; /* position of the text's box */
} line_name;

typedef struct name_list {
  const km_plot_layout *layout;
  km_frame frame;
  const km_curve *curves;
  size_t curve_count;
  line_name *names; /* order by the height of the line's end */
  size_t count;
  km_font font;
} name_list;

void km_plot_spread(double *places, size_t count, double gap, double low, double high, km_arena *arena) {
  /* Less i gaps, the places need only ascend: pool adjacent violators, then move into the bounds.
   */
  double *means = KM_ARENA_NEW(arena, double, count + 1);
  size_t *sizes = KM_ARENA_NEW(arena, size_t, count + 1);
  if (arena->failed)
    return;
  size_t pools = 0;
  for (size_t i = 0; i < count; i++) {
    means[pools] = places[i] - (double)i * gap;
    sizes[pools++] = 1;
    for (; pools > 1 && means[pools - 2] > means[pools - 1]; pools--) {
      double first = (double)sizes[pools - 2], second = (double)sizes[pools - 1];
      means[pools - 2] = (first * means[pools - 2] + second * means[pools - 1]) / (first + second);
      sizes[pools - 2] += sizes[pools - 1];
    }
  }
  double last = high - (double)(count ? count - 1 : 0) * gap;
  for (size_t pool = 0, i = 0; pool < pools; pool++)
    for (size_t k = 0; k < sizes[pool]; k++, i++)
      places[i] = fmax(low, fmin(last, means[pool])) + (double)i * gap;
}

double km_plot_names_room(const km_plot_layout *layout, const km_plot_panel *panel) {
  double widest = 0;
  for (size_t i = 0; i < panel->series_count; i++)
    if (panel->series[i].name)
      widest = fmax(widest, km_canvas_measure(layout->canvas, &layout->name, panel->series[i].name).x);
  return widest > 0 ? widest + lead : 0;
}

static bool above(const km_curve *a, const km_curve *b) {
  const double coincident = 0.5; /* points: then the way the lines came decides */
  if (fabs(a->end.y - b->end.y) > coincident)
    return a->end.y < b->end.y;
  return a->before < b->before;
}

static void gather(name_list *list, const km_plot_panel *panel) {
  double right = list->frame.left + list->frame.width;
  for (size_t i = 0; i < panel->series_count; i++) {
    const km_curve *curve = &list->curves[i];
    if (!panel->series[i].name || !curve->has_end)
      continue;
    line_name name = {.series = &panel->series[i], .curve = curve};
    name.width = km_canvas_measure(list->layout->canvas, &list->font, name.series->name).x;
    name.beside = curve->end.x + same_place + lead + name.width > right;
    size_t at = list->count++;
    for (; at > 0 && above(curve, list->names[at - 1].curve); at--)
      list->names[at] = list->names[at - 1];
    list->names[at] = name;
  }
}

static void draw_name(const name_list *list, const line_name *name, double middle) {
  km_canvas *canvas = list->layout->canvas;
  km_pen leader = km_palette_pen(name->series->colour, 0, 0.5);
  km_canvas_point end = name->curve->end;
  if (name->left - end.x > lead_straight + moved)
    km_canvas_line(canvas, &leader, (km_canvas_point){end.x + 1, end.y}, (km_canvas_point){name->left - 1.5, middle});
  km_canvas_text(canvas, &list->font, km_palette_text(name->series->colour), name->series->name,
                 (km_canvas_point){name->left, middle}, (km_anchor){0, 0.5, 0});
}

/* Crowded names shrink; those past what fits at the least size are only counted. */
static size_t fit_beside(name_list *list, size_t count, double room) {
  double size = room / ((double)count * spacing);
  list->font.size = fmax(size_least, fmin(list->font.size, size));
  size_t capacity = (size_t)(room / (spacing * list->font.size) + 0.01);
  return count <= capacity ? count : capacity > 0 ? capacity - 1 : 0;
}

static void draw_more(const name_list *list, size_t missing, double left, double middle) {
  char text[32];
  snprintf(text, sizeof text, "+ %zu more", missing);
  km_canvas_text(list->layout->canvas, &list->font, km_palette_text(-1), text, (km_canvas_point){left, middle},
                 (km_anchor){0, 0.5, 0});
}

/* True if every name is at its line's end, so that no leader is needed. */
static bool all_straight(const name_list *list, line_name *const *names, const double *places, size_t count) {
  double right = list->frame.left + list->frame.width;
  for (size_t i = 0; i < count; i++)
    if (fabs(places[i] - names[i]->curve->end.y) > moved || names[i]->curve->end.x < right - moved)
      return false;
  return true;
}

static size_t find_beside(const name_list *list, line_name **names) {
  size_t count = 0;
  for (size_t i = 0; i < list->count; i++)
    if (list->names[i].beside)
      names[count++] = &list->names[i];
  return count;
}

static void draw_beside(name_list *list, bool below_flags) {
  km_arena *arena = list->layout->arena;
  line_name **names = KM_ARENA_NEW(arena, line_name *, list->count + 1);
  double *places = KM_ARENA_NEW(arena, double, list->count + 2);
  size_t all = names && places ? find_beside(list, names) : 0;
  if (all == 0)
    return;
  const km_font font = list->font;
  double half = 0.5 * spacing * font.size, bottom = list->frame.top + list->frame.height;
  double top = list->frame.top + (below_flags ? half : 0);
  size_t count = fit_beside(list, all, bottom - top + 2 * half);
  for (size_t i = 0; i < count; i++)
    places[i] = names[i]->curve->end.y;
  places[count] = bottom; /* space for the number of omitted names */
  km_plot_spread(places, count < all ? count + 1 : count, spacing * list->font.size, top, bottom, arena);
  bool straight = all_straight(list, names, places, count);
  double left = list->frame.left + list->frame.width + (straight ? lead_straight : lead);
  for (size_t i = 0; i < count; i++) {
    names[i]->left = left;
    draw_name(list, names[i], places[i]);
  }
  if (count < all)
    draw_more(list, all - count, left, places[count]);
  list->font = font;
}

/* Cost of a box: lines and placed names that it covers, and its part outside the frame. */
static double hidden(const name_list *list, const line_name *name, double left, double middle) {
  const double worse = 100;
  double half = 0.5 * spacing * list->font.size;
  double top = middle - half, bottom = middle + half, right = left + name->width;
  double cost = 0;
  if (top < list->frame.top || bottom > list->frame.top + list->frame.height)
    cost += worse;
  for (size_t i = 0; i < list->curve_count; i++)
    cost += (double)km_curve_hits(&list->curves[i], left - 1, top, right + 1, bottom);
  for (size_t i = 0; i < list->count; i++) {
    const line_name *other = &list->names[i];
    if (other->placed && left < other->left + other->width && other->left < right && top < other->top + 2 * half &&
        other->top < bottom)
      cost += worse;
  }
  return cost;
}

/* The shift of a whole column of names, up or down, that hides least; the least such shift. */
static double best_shift(const name_list *list, line_name *const *names, const double *places, size_t count,
                         double left) {
  const double dearness = 0.1; /* cost of a shift by half a row, relative to a covered crossing */
  double half_row = 0.5 * spacing * list->font.size;
  double best = 0, best_cost = DBL_MAX;
  for (int step = 0; step <= 64; step++) {
    int halves = step % 2 ? (step + 1) / 2 : -step / 2; /* 0, 1, -1, 2, -2, ... */
    double shift = halves * half_row;
    double cost = dearness * (double)count * abs(halves);
    if (cost >= best_cost)
      break;
    for (size_t i = 0; i < count && cost < best_cost; i++)
      cost += hidden(list, names[i], left, places[i] + shift);
    if (cost < best_cost) {
      best_cost = cost;
      best = shift;
    }
  }
  return best;
}

/* Names of lines that stop at about the same place as names[first], in one column. */
static void draw_inside(name_list *list, size_t first) {
  km_arena *arena = list->layout->arena;
  line_name **names = KM_ARENA_NEW(arena, line_name *, list->count + 1);
  double *places = KM_ARENA_NEW(arena, double, list->count + 1);
  if (!names || !places)
    return;
  double x = list->names[first].curve->end.x, left = x;
  size_t count = 0;
  for (size_t i = first; i < list->count; i++) {
    line_name *name = &list->names[i];
    if (name->beside || name->placed || fabs(name->curve->end.x - x) > same_place)
      continue;
    left = fmax(left, name->curve->end.x);
    places[count] = name->curve->end.y;
    names[count++] = name;
  }
  const km_frame *frame = &list->frame;
  double gap = spacing * list->font.size;
  km_plot_spread(places, count, gap, frame->top + gap / 2, frame->top + frame->height - gap / 2, arena);
  double offset = count > 1 ? lead : lead_straight;
  double shift = best_shift(list, names, places, count, left + offset);
  if (shift != 0 && offset < lead) {
    offset = lead;
    shift = best_shift(list, names, places, count, left + offset);
  }
  left += offset;
  for (size_t i = 0; i < count; i++) {
    double middle = places[i] + shift;
    names[i]->left = left;
    names[i]->top = middle - gap / 2;
    names[i]->placed = true;
    km_canvas_rectangle(list->layout->canvas, (km_colour){1, 1, 1, 0.85}, left - 1, names[i]->top, names[i]->width + 2,
                        gap);
    draw_name(list, names[i], middle);
  }
}

void km_plot_names_draw(const km_plot_layout *layout, size_t panel, const km_curve *curves) {
  const km_plot_panel *source = &layout->plot->panels[panel];
  name_list list = {.layout = layout,
                    .frame = km_plot_layout_frame(layout, panel),
                    .curves = curves,
                    .curve_count = source->series_count,
                    .names = KM_ARENA_NEW(layout->arena, line_name, source->series_count + 1),
                    .font = layout->name};
  if (!list.names)
    return;
  gather(&list, source);
  draw_beside(&list, layout->flags[panel].count > 0);
  for (size_t i = 0; i < list.count; i++)
    if (!list.names[i].beside && !list.names[i].placed)
      draw_inside(&list, i);
}
