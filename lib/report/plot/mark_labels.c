/* Names of the marks on the x axis, placed above the panel without overlaps. */
#include "report/canvas/palette.h"
#include "report/plot/plot_layout.h"

#include <math.h>
#include <string.h>

enum { ROWS_MOST = 4 };

static const km_colour ink = {0.25, 0.25, 0.25, 1};
static const double nearly_same = 2; /* points: signs closer than this share a name */
static const double name_gap = 6, pole_gap = 2.5;

/* Colour of a mark or of its flag. */
static km_colour ink_of(int own_colour) {
  return own_colour > 0 ? km_palette_text(own_colour - 1) : ink;
}

static double axis_part(const km_axis *axis, double x) {
  return x / (axis->high - axis->low) - axis->low / (axis->high - axis->low);
}

static bool named(const km_plot_mark *mark) {
  return mark->name && km_axis_takes(mark->x);
}

static double name_width(const km_plot_layout *layout, const char *name) {
  return km_canvas_measure(layout->canvas, &layout->mark, name).x + pole_gap;
}

double km_plot_flags_room(const km_plot_layout *layout, const km_plot_panel *panel, double width) {
  double room = 0;
  for (size_t i = 0; i < panel->mark_count; i++) {
    const km_plot_mark *mark = &panel->marks[i];
    double part = named(mark) ? axis_part(&layout->x, mark->x) : 0;
    if (part <= 0)
      continue;
    /* part * (width - needed) + name = width, so that the name ends at the right border */
    room = fmax(room, width - (width - name_width(layout, mark->name)) / part);
  }
  return room;
}

/* Arena memory is zeroed, so the joined text ends where it should. */
static const char *join(km_arena *arena, const char *a, const char *b) {
  if (!strcmp(a, b))
    return a;
  size_t first = strlen(a), second = strlen(b);
  char *text = KM_ARENA_NEW(arena, char, first + second + 3);
  if (!text)
    return a;
  memcpy(text, a, first);
  memcpy(text + first, ", ", 2);
  memcpy(text + first + 2, b, second);
  return text;
}

/* Insertion keeps the caller's order where marks share a place to the rounding of located events. */
static void insert(km_plot_flags *flags, km_plot_flag flag) {
  static const double same_place = 1e-6; /* points */
  size_t i = flags->count++;
  for (; i > 0 && flags->flags[i - 1].at > flag.at + same_place; i--)
    flags->flags[i] = flags->flags[i - 1];
  flags->flags[i] = flag;
}

/* A joined name may exceed the space reserved for single names: it ends at the cell's border. */
static void merge(const km_plot_layout *layout, km_plot_flags *flags, size_t i, double frame_width) {
  km_plot_flag *flag = &flags->flags[i];
  flag->name = join(layout->arena, flag->name, flag[1].name);
  flag->width = fmin(name_width(layout, flag->name), frame_width + layout->right - flag->at);
  flags->count--;
  memmove(flag + 1, flag + 2, (flags->count - i - 1) * sizeof *flag);
}

static size_t nearest_pair(const km_plot_flags *flags) {
  size_t best = 0;
  for (size_t i = 1; i + 1 < flags->count; i++)
    if (flags->flags[i + 1].at - flags->flags[i].at < flags->flags[best + 1].at - flags->flags[best].at)
      best = i;
  return best;
}

/* Placement from the right: a flag is above all poles and flags that it overlaps, so no pole crosses a name. */
static void choose_rows(km_plot_flags *flags) {
  flags->rows = 0;
  for (size_t i = flags->count; i-- > 0;) {
    km_plot_flag *flag = &flags->flags[i];
    flag->row = 0;
    for (size_t j = i + 1; j < flags->count; j++)
      if (flags->flags[j].at < flag->at + flag->width + name_gap && flags->flags[j].row >= flag->row)
        flag->row = flags->flags[j].row + 1;
    if (flag->row + 1 > flags->rows)
      flags->rows = flag->row + 1;
  }
}

km_plot_flags km_plot_flags_make(const km_plot_layout *layout, const km_plot_panel *panel, double frame_width) {
  km_plot_flags flags = {.flags = KM_ARENA_NEW(layout->arena, km_plot_flag, panel->mark_count + 1)};
  if (!flags.flags)
    return flags;
  for (size_t i = 0; i < panel->mark_count; i++) {
    const km_plot_mark *mark = &panel->marks[i];
    if (named(mark))
      insert(&flags, (km_plot_flag){.x = mark->x,
                                    .at = axis_part(&layout->x, mark->x) * frame_width,
                                    .width = name_width(layout, mark->name),
                                    .name = mark->name,
                                    .own_colour = mark->own_colour});
  }
  for (size_t i = 0; i + 1 < flags.count;)
    if (flags.flags[i + 1].at - flags.flags[i].at < nearly_same)
      merge(layout, &flags, i, frame_width);
    else
      i++;
  choose_rows(&flags);
  while (flags.rows > ROWS_MOST) {
    merge(layout, &flags, nearest_pair(&flags), frame_width);
    choose_rows(&flags);
  }
  return flags;
}

static void draw_sign(const km_plot_layout *layout, const km_frame *frame, double x, km_colour colour) {
  static const double dash[] = {1, 2.5};
  const km_pen pen = {.colour = colour, .width = 0.6, .dash = dash, .dash_count = 2};
  double bottom = frame->top + frame->height, half = 0.42 * layout->mark_room;
  km_canvas_line(layout->canvas, &pen, (km_canvas_point){x, bottom}, (km_canvas_point){x, frame->top});
  const km_canvas_point triangle[] = {
      {x, bottom + 0.8}, {x + half, bottom + layout->mark_room}, {x - half, bottom + layout->mark_room}};
  km_canvas_polygon(layout->canvas, colour, triangle, 3);
}

void km_plot_flags_draw(const km_plot_layout *layout, size_t panel) {
  const km_plot_panel *source = &layout->plot->panels[panel];
  const km_plot_flags *flags = &layout->flags[panel];
  const km_frame frame = km_plot_layout_frame(layout, panel);
  double row_height = km_canvas_measure(layout->canvas, &layout->mark, "x").y;
  for (size_t i = 0; i < source->mark_count; i++)
    if (km_axis_takes(source->marks[i].x))
      draw_sign(layout, &frame, km_frame_map(&frame, source->marks[i].x, frame.y_low).x,
                ink_of(source->marks[i].own_colour));
  for (size_t i = 0; i < flags->count; i++) {
    const km_plot_flag *flag = &flags->flags[i];
    const km_pen pole = {.colour = ink_of(flag->own_colour), .width = 0.5};
    double x = frame.left + flag->at, base = frame.top - 2 - (double)flag->row * row_height;
    km_canvas_line(layout->canvas, &pole, (km_canvas_point){x, frame.top},
                   (km_canvas_point){x, base - 0.8 * row_height});
    km_font font = layout->mark;
    font.width = fmax(flag->width - pole_gap, 1) + 0.5; /* rounding must not cost a letter */
    km_canvas_text(layout->canvas, &font, ink_of(flag->own_colour), flag->name, (km_canvas_point){x + pole_gap, base},
                   (km_anchor){0, 1, 0});
  }
}
