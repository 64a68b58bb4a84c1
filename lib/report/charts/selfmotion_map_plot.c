/* The map of self-motions as a picture: cells coloured by the objective, hatches, tracks, axes. */
#include "report/charts/selfmotion_map_plot.h"

#include "arm/selfmotion/selfmotion_map.h"
#include "report/canvas/palette.h"
#include "report/charts/track_plot.h"

#include <stdio.h>
#include <string.h>

enum { STATIONS = 80 };
static const km_colour ink = {0.15, 0.15, 0.15, 1}, grey = {0.40, 0.40, 0.40, 1};
static const double page_width = 560, page_height = 380, margin = 14;

typedef struct picture {
  const km_tracks *tracks;
  const km_motion_map *map;
  km_canvas *canvas;
  km_frame frame;
  double low, high; /* range of the objective in the map */
} picture;

static double value_at(const km_station *s, double u) {
  int i = 0;
  while (i + 2 < s->count && s->u[i + 1] <= u)
    ++i;
  if (s->count < 2)
    return s->count ? s->value[0] : (double)NAN;
  double x = (u - s->u[i]) / (s->u[i + 1] - s->u[i]);
  x = x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
  return s->value[i] + x * (s->value[i + 1] - s->value[i]);
}

static bool inside(const km_station *s, double u) {
  for (int i = 0; i < s->arc_count; ++i)
    if (u >= s->arcs[i].from && u <= s->arcs[i].to)
      return true;
  return false;
}

/* The strip of a station: halfway to its neighbours. */
static void strip(const picture *p, int i, double *left, double *right) {
  const km_station *s = p->map->stations;
  int last = p->map->count - 1;
  *left = km_frame_map(&p->frame, i > 0 ? 0.5 * (s[i - 1].s + s[i].s) : s[i].s, 0.0).x;
  *right = km_frame_map(&p->frame, i < last ? 0.5 * (s[i].s + s[i + 1].s) : s[i].s, 0.0).x;
}

static void fill(const picture *p, double left, double right, double u0, double u1, km_colour colour) {
  double top = km_frame_map(&p->frame, p->frame.x_low, u1).y, bottom = km_frame_map(&p->frame, p->frame.x_low, u0).y;
  km_canvas_rectangle(p->canvas, colour, left, top, right - left + 0.3, bottom - top + 0.3);
}

/* Colours outside the limits are paler. */
static km_colour paler(km_colour c) {
  const double share = 0.55;
  return (km_colour){c.red + share * (1 - c.red), c.green + share * (1 - c.green), c.blue + share * (1 - c.blue), 1};
}

/* An arc narrower than a cell shows as one. */
static bool holds_narrow(const km_station *s, double u, double h) {
  for (int i = 0; i < s->arc_count; ++i) {
    double middle = 0.5 * (s->arcs[i].from + s->arcs[i].to);
    if (s->arcs[i].to - s->arcs[i].from < h && fabs(middle - u) <= 0.5 * h)
      return true;
  }
  return false;
}

int km_map_cells(const km_station *s, double low, double high, km_map_cell *out) {
  double h = (s->high - s->low) / KM_MAP_CELLS;
  int count = 0;
  for (int c = 0; c < KM_MAP_CELLS; ++c) {
    double u = s->low + h * (c + 0.5), part = (value_at(s, u) - low) / (high - low);
    int shade = part >= 1.0 ? KM_MAP_SHADES - 1 : part <= 0.0 ? 0 : (int)(part * KM_MAP_SHADES);
    bool outside = !inside(s, u) && !holds_narrow(s, u, h);
    if (count == 0 || out[count - 1].shade != shade || out[count - 1].outside != outside)
      out[count++] = (km_map_cell){s->low + h * c, 0.0, shade, outside};
    out[count - 1].to = s->low + h * (c + 1);
  }
  return count;
}

static void paint_station(const picture *p, int i) {
  const km_station *s = &p->map->stations[i];
  km_map_cell cells[KM_MAP_CELLS];
  double left, right;
  strip(p, i, &left, &right);
  for (int c = 0, count = km_map_cells(s, p->low, p->high, cells); c < count; ++c) {
    km_colour colour = km_map_shade(cells[c].shade);
    fill(p, left, right, cells[c].from, cells[c].to, cells[c].outside ? paler(colour) : colour);
  }
}

static int station_at(const picture *p, double s) {
  int i = 0;
  while (i + 1 < p->map->count && 0.5 * (p->map->stations[i].s + p->map->stations[i + 1].s) < s)
    ++i;
  return i;
}

/* Diagonals where the limits forbid, in runs. */
static void hatch(const picture *p) {
  const km_frame *f = &p->frame;
  const km_pen pen = {.colour = {0.25, 0.25, 0.25, 0.8}, .width = 0.5};
  const double gap = 7.0, step = 0.75;
  for (double start = f->left - f->height; start < f->left + f->width; start += gap) {
    km_canvas_point from = {0, 0}, to = {0, 0};
    bool on = false;
    for (double t = 0.0; t <= f->height + step; t += step) {
      double x = start + t, y = f->top + f->height - t;
      bool forbidden = false;
      if (t <= f->height && x >= f->left && x <= f->left + f->width) {
        double s = f->x_low + (x - f->left) / f->width * (f->x_high - f->x_low);
        double u = f->y_low + (f->top + f->height - y) / f->height * (f->y_high - f->y_low);
        const km_station *station = &p->map->stations[station_at(p, s)];
        forbidden = s <= p->map->stations[p->map->count - 1].s && u >= station->low && u <= station->high &&
                    !inside(station, u);
      }
      if (forbidden && !on)
        from = (km_canvas_point){x, y};
      if (!forbidden && on)
        km_canvas_line(p->canvas, &pen, from, to);
      to = (km_canvas_point){x, y};
      on = forbidden;
    }
  }
}

/* Boundaries of the joint limits: ends of the arcs, connected between stations if they are near. */
static void outline(const picture *p) {
  const km_pen pen = {.colour = {0.1, 0.1, 0.1, 1}, .width = 0.8};
  for (int i = 0; i + 1 < p->map->count; ++i) {
    const km_station *a = &p->map->stations[i], *b = &p->map->stations[i + 1];
    for (int k = 0; k < a->arc_count; ++k)
      for (int end = 0; end < 2; ++end) {
        double u = end ? a->arcs[k].to : a->arcs[k].from, best = (double)INFINITY, to = 0.0;
        if (u <= a->low + 1e-9 || u >= a->high - 1e-9)
          continue;
        for (int j = 0; j < b->arc_count; ++j) {
          double v = end ? b->arcs[j].to : b->arcs[j].from;
          if (fabs(v - u) < fabs(best)) {
            best = v - u;
            to = v;
          }
        }
        if (fabs(best) < 0.06 * (p->frame.y_high - p->frame.y_low))
          km_canvas_line(p->canvas, &pen, km_frame_map(&p->frame, a->s, u), km_frame_map(&p->frame, b->s, to));
      }
  }
}

/* Black, red, and colours that contrast with the map. */
static km_pen track_pen(int number) {
  static const int colours[] = {3, 1, 2, 4, 5, 6, 0};
  km_pen pen = km_palette_pen(colours[number % 7], number, 1.7);
  if (number == 1)
    pen.colour = (km_colour){0.85, 0.1, 0.1, 1};
  return pen;
}

/* A track over the map, broken where it is on another component or passes where the curve is cut open. */
static void draw_track(const picture *p, int index, int number) {
  const km_track *t = p->tracks->items[index];
  km_canvas_point points[STATIONS + 3];
  const km_pen halo = {.colour = {1, 1, 1, 0.9}, .width = 3.4}, pen = track_pen(number);
  size_t count = 0;
  double last = 0.0;
  for (int i = 0; i <= p->map->count; ++i) {
    double u = (double)NAN;
    const km_station *s = i < p->map->count ? &p->map->stations[i] : NULL;
    if (s && (size_t)s->sample < km_table_rows(t->table) && s->sample <= t->end.sample) {
      double q[KM_ARM_MAX_JOINTS];
      const double *row = km_table_row(t->table, (size_t)s->sample) + km_table_span(t->table, "q.").first;
      for (int k = 0; k < t->arm->n; ++k)
        q[k] = km_arm_from_units(t->arm, k, row[k]);
      u = km_station_find(p->map, s, q);
    }
    bool jumps = count > 0 && fabs(u - last) > 0.4 * (p->frame.y_high - p->frame.y_low);
    if (!isfinite(u) || jumps) {
      if (count > 1) {
        km_canvas_polyline(p->canvas, &halo, points, count);
        km_canvas_polyline(p->canvas, &pen, points, count);
      }
      if (count > 0 && t->end.stop && !isfinite(u))
        km_canvas_circle(p->canvas, pen.colour, &halo, points[count - 1], 3.0);
      count = 0;
    }
    if (isfinite(u))
      points[count++] = km_frame_map(&p->frame, s->s, u); /* NOLINT(*NullDereference): u is a place in s */
    last = u;
  }
}

static void legend(const picture *p, double left, double top) {
  const km_font font = {.size = 8.5, .width = 110, .lines = 1};
  int number = 0;
  for (int i = 0; i < p->tracks->count; ++i) {
    char label[64];
    if (!p->tracks->items[i])
      continue;
    km_tracks_label(p->tracks, i, ' ', label, sizeof label);
    const km_pen pen = track_pen(number);
    double y = top + 13.0 * number++;
    km_canvas_line(p->canvas, &pen, (km_canvas_point){left, y}, (km_canvas_point){left + 22, y});
    km_canvas_text(p->canvas, &font, ink, label, (km_canvas_point){left + 27, y}, (km_anchor){0, 0.5, 0});
  }
}

static void colour_bar(const picture *p, double left, double top, double height) {
  const km_font font = {.size = 8.5};
  char multiplier[KM_AXIS_LABEL];
  km_text name = {0};
  km_map_colours_draw(p->canvas, p->low, p->high, left, top, height, multiplier);
  km_text_format(&name, "%s %s", km_objective_name(&p->tracks->study->objective), multiplier);
  km_canvas_words(p->canvas, &font, ink, &name, (km_canvas_point){left, top - 6}, (km_anchor){0, 1, 0});
}

static void axes(const picture *p) {
  const km_frame *f = &p->frame;
  const km_font label = {.size = 9.5};
  char text[KM_AXIS_LABEL], name[160];
  km_axis x = km_axis_fit(f->x_low, f->x_high, 8, false, false), y = km_axis_fit(f->y_low, f->y_high, 8, false, false);
  km_map_axes_draw(p->canvas, f, &x, &y, 8.5, 5);
  km_axis_multiplier(&x, text);
  snprintf(name, sizeof name, "s: travel, and turns times L (%s%s%s)", *text ? text : "", *text ? " " : "",
           p->map->arm->mechanism->model->units.length->suffix);
  km_canvas_text(p->canvas, &label, ink, name, (km_canvas_point){f->left + 0.5 * f->width, f->top + f->height + 18},
                 (km_anchor){0.5, 0, 0});
  km_canvas_text(p->canvas, &label, ink, "self-motion from the carried start (rad)",
                 (km_canvas_point){margin, f->top + 0.5 * f->height}, (km_anchor){0.5, 0, -acos(0.0)});
}

static void range_of(picture *p) {
  p->low = (double)INFINITY;
  p->high = -(double)INFINITY;
  p->frame.y_low = (double)INFINITY;
  p->frame.y_high = -(double)INFINITY;
  for (int i = 0; i < p->map->count; ++i) {
    const km_station *s = &p->map->stations[i];
    p->frame.y_low = fmin(p->frame.y_low, s->low);
    p->frame.y_high = fmax(p->frame.y_high, s->high);
    for (int k = 0; k < s->count; ++k) {
      p->low = fmin(p->low, s->value[k]);
      p->high = fmax(p->high, s->value[k]);
    }
  }
  /* Values below 0 are hatched in any case. */
  if (km_objective_single(&p->tracks->study->objective) == KM_LIMIT_DISTANCE)
    p->low = fmax(p->low, -0.25);
  km_axis_widen(&p->low, &p->high);
  km_axis_widen(&p->frame.y_low, &p->frame.y_high);
}

static void paint(picture *p) {
  const km_font title = {.size = 13, .bold = true, .width = page_width - 2 * margin},
                subtitle = {.size = 9, .width = page_width - 2 * margin};
  const km_path *path = p->tracks->study->path;
  p->frame = (km_frame){.left = 62, .top = 62, .width = page_width - 62 - 150, .height = page_height - 62 - 46};
  p->frame.x_high = km_path_length(path, path->samples - 1);
  range_of(p);
  km_canvas_text(p->canvas, &title, ink, "Every pose that holds the effector, along the path",
                 (km_canvas_point){margin, margin}, (km_anchor){0, 0, 0});
  km_text about = {0};
  const km_model *model = p->map->arm->mechanism->model;
  km_text_format(&about, "%s · %s, %s · L = %g %s · hatched: outside the joint limits · dots: where a track ends",
                 p->tracks->model, model->units.angle->word, model->units.length->word, p->map->arm->length,
                 model->units.length->suffix);
  km_canvas_words(p->canvas, &subtitle, grey, &about, (km_canvas_point){margin, margin + 18}, (km_anchor){0, 0, 0});
  km_canvas_clip(p->canvas, p->frame.left, p->frame.top, p->frame.width, p->frame.height);
  for (int i = 0; i < p->map->count; ++i)
    paint_station(p, i);
  hatch(p);
  outline(p);
  int number = 0;
  for (int i = 0; i < p->tracks->count; ++i)
    number += p->tracks->items[i] != NULL;
  for (int i = p->tracks->count - 1; i >= 0; --i) /* the first lie on top */
    if (p->tracks->items[i])
      draw_track(p, i, --number);
  km_canvas_release(p->canvas);
  axes(p);
  double right = p->frame.left + p->frame.width + 16;
  colour_bar(p, right, p->frame.top + 14, 130);
  legend(p, right, p->frame.top + 166);
}

km_status km_tracks_map(const km_tracks *t, km_picture_format format, km_text *out, km_error *error) {
  km_motion_map map;
  km_status status = km_check_tracks(t, false, format, out, error);
  if (!status && t->study->start_status)
    status = km_fail(error, KM_USAGE, "%s", t->study->start_error.text);
  if (status)
    return status;
  status =
      km_motion_map_create(t->study->arm, t->study->path, t->study->start, &t->study->objective, STATIONS, &map, error);
  picture p = {.tracks = t, .map = &map};
  if (!status)
    status = km_canvas_create(format, page_width, page_height, out, &p.canvas, error);
  if (!status) {
    paint(&p);
    status = km_canvas_finish(p.canvas, error);
  }
  km_canvas_free(p.canvas);
  km_motion_map_free(&map);
  return status;
}
