/* The page around a drawing: titles and axes above, the scale bar beneath. */
#include "report/drawing/drawing_parts.h"

static const double size_least = 120; /* points: less can't hold a drawing and a title */
static const double width_default = 504;

typedef struct page {
  double width, height, margin, head, foot;
  double size; /* scale of letters and lines */
  km_font title, subtitle, note;
  km_text about; /* the subtitle */
} page;

static void describe(const km_studio *s, km_text *out) {
  const km_drawing_def *d = s->drawing;
  km_text_format(out, "%s · ", d->name ? d->name : "");
  km_text_add(out, s->view.name);
  if (d->pose_count > 1 && !d->alone)
    km_text_format(out, " · %zu poses, pale: the later ones", d->pose_count);
  for (size_t t = 0; t < d->trace_count; ++t)
    km_text_format(out, "%s%s", t ? ", " : " · path of ", d->traces[t].name);
}

/* The largest of 1, 2, 5 times a power of ten that is at most `most`. */
static double round_length(double most) {
  double power = floor(log10(most));
  for (int i = 0; i < 4; ++i) {
    static const double mantissas[] = {10, 5, 2, 1};
    double length = power < 0.0 ? mantissas[i] / pow(10.0, -power) : mantissas[i] * pow(10.0, power);
    if (length <= most * (1.0 + 1e-9))
      return length;
  }
  return most;
}

/* A single point has no scale. */
static bool has_size(const km_studio *s) {
  return s->extent.high[0] > s->extent.low[0] || s->extent.high[1] > s->extent.low[1];
}

static void draw_scale(const km_studio *s, const page *p) {
  if (!has_size(s))
    return;
  double length = round_length(0.25 * p->width / s->view.scale);
  char text[KM_NUMBER_TEXT + 8] = "";
  km_text label = {0};
  km_number_format(text, length);
  km_text_format(&label, "%s %s", text, s->drawing->mechanism->model->units.length->suffix);
  double x = p->margin, y = p->height - p->margin - 3.0 * p->size, end = x + length * s->view.scale;
  km_pen pen = {.colour = {0.1, 0.1, 0.1, 1}, .width = 1.2 * p->size};
  km_canvas_line(s->canvas, &pen, (km_canvas_point){x, y}, (km_canvas_point){end, y});
  for (int k = 0; k < 2; ++k)
    km_canvas_line(s->canvas, &pen, (km_canvas_point){k ? end : x, y - 2.5 * p->size},
                   (km_canvas_point){k ? end : x, y + 2.5 * p->size});
  km_canvas_words(s->canvas, &p->note, pen.colour, &label, (km_canvas_point){end + 5.0 * p->size, y},
                  (km_anchor){0, 0.5, 0});
}

/* Direction of an axis's name on the page: beyond the tip, or sideways if a longer axis has the same direction. */
static km_spot name_direction(const km_spot axes[3], int k, double length) {
  km_spot past = {axes[k].x / length, axes[k].y / length, 0};
  for (int i = 0; i < 3; ++i) {
    double other = hypot(axes[i].x, axes[i].y);
    double along = other > length ? (past.x * axes[i].x + past.y * axes[i].y) / other : 0.0;
    if (along > 0.9)
      return (km_spot){-past.y, past.x, 0};
  }
  return past;
}

/* Draws the inertial axes. */
static void draw_axes(const km_studio *s, const page *p) {
  static const km_vec3 units[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const char *const names[] = {"x", "y", "z"};
  const km_pen pen = {.colour = {0.3, 0.3, 0.3, 1}, .width = 0.9 * p->size};
  const double arm = 15.0 * p->size;
  const km_spot from = {p->width - p->margin - 1.6 * arm, p->margin + 1.5 * arm, 0};
  km_spot axes[3];
  for (int k = 0; k < 3; ++k)
    axes[k] = km_project_direction(&s->view, units[k]);
  for (int k = 0; k < 3; ++k) {
    double length = hypot(axes[k].x, axes[k].y);
    if (length < 0.1)
      continue;
    const km_spot d = {axes[k].x / length, axes[k].y / length, 0};
    const km_canvas_point tip = km_page(from, arm, axes[k]);
    const km_spot at = {tip.x, tip.y, 0}, side = {-d.y, d.x, 0};
    const km_canvas_point back = km_page(at, -2.5 * p->size, d);
    const km_spot behind = {back.x, back.y, 0};
    const km_canvas_point head[] = {km_page(at, 2.0 * p->size, d), km_page(behind, 1.6 * p->size, side),
                                    km_page(behind, -1.6 * p->size, side)};
    km_canvas_line(s->canvas, &pen, (km_canvas_point){from.x, from.y}, tip);
    km_canvas_polygon(s->canvas, pen.colour, head, 3);
    km_canvas_text(s->canvas, &p->note, pen.colour, names[k],
                   km_page(at, 7.5 * p->size, name_direction(axes, k, length)), (km_anchor){0.5, 0.5, 0});
  }
}

/* Height by the shape, within bounds. */
static void choose_size(const km_studio *s, page *p) {
  const km_drawing_def *d = s->drawing;
  double width = s->extent.high[0] - s->extent.low[0], height = s->extent.high[1] - s->extent.low[1];
  double shape = width > 0.0 ? height / width : height > 0.0 ? 1.0 : 0.0;
  p->width = d->width > 0.0 ? d->width : width_default;
  p->height = d->height > 0.0 ? d->height : 130.0 + fmin(fmax((p->width - 78.0) * shape, 100.0), 360.0);
}

static void choose_fonts(page *p) {
  p->size = fmin(fmax(sqrt(fmin(p->width / 504.0, p->height / 324.0)), 0.85), 1.5);
  p->margin = 9.0 * p->size;
  double inner = p->width - 2.0 * p->margin - 50.0 * p->size; /* less the axes */
  p->title = (km_font){.size = 11.0 * p->size, .bold = true, .width = inner, .lines = 2};
  p->subtitle = (km_font){.size = 8.0 * p->size, .width = inner, .lines = 2};
  p->note = (km_font){.size = 7.5 * p->size};
}

static const char *title_of(const km_drawing_def *d) {
  return d->title ? d->title : "";
}
static const char *about_of(const page *p) {
  return p->about.data ? p->about.data : "";
}

static void draw_titles(const km_studio *s, const page *p) {
  const km_colour black = {0, 0, 0, 1}, grey = {0.3, 0.3, 0.3, 1};
  double title = km_canvas_measure(s->canvas, &p->title, title_of(s->drawing)).y;
  const km_anchor corner = {0, 0, 0};
  km_canvas_text(s->canvas, &p->title, black, title_of(s->drawing), (km_canvas_point){p->margin, p->margin}, corner);
  km_canvas_text(s->canvas, &p->subtitle, grey, about_of(p), (km_canvas_point){p->margin, p->margin + title}, corner);
}

/* Rectangle between titles and scale bar. */
static km_rectangle place_of(km_canvas *canvas, const km_drawing_def *d, page *p) {
  double title = km_canvas_measure(canvas, &p->title, title_of(d)).y;
  double subtitle = km_canvas_measure(canvas, &p->subtitle, about_of(p)).y;
  p->head = p->margin + fmax(title + subtitle + 3.0 * p->size, 30.0 * p->size);
  p->foot = p->margin + 1.5 * p->note.size;
  return (km_rectangle){p->margin, p->head, p->width - 2.0 * p->margin, p->height - p->head - p->foot};
}

static void draw_page(const km_drawing_def *d, km_canvas *canvas, page *p, km_status *status, km_error *error) {
  km_studio s = {.drawing = d, .canvas = canvas, .place = place_of(canvas, d, p)};
  if (km_studio_open(&s)) {
    km_studio_draw(&s);
    if (d->mechanism->model->joint_count == 0)
      km_canvas_text(canvas, &p->subtitle, (km_colour){0.4, 0.4, 0.4, 1}, "no bodies",
                     (km_canvas_point){0.5 * p->width, 0.5 * p->height}, (km_anchor){0.5, 0.5, 0});
    draw_titles(&s, p);
    draw_scale(&s, p);
    draw_axes(&s, p);
  }
  *status = km_studio_close(&s, error);
}

/* Size and subtitle need the view, but not the canvas. */
static km_status plan_page(const km_drawing_def *d, page *p, km_error *error) {
  km_studio s = {.drawing = d, .place = {0, 0, width_default, width_default}};
  if (km_studio_open(&s)) {
    choose_size(&s, p);
    choose_fonts(p);
    describe(&s, &p->about);
  }
  km_status status = km_studio_close(&s, error);
  return !status && p->about.failed ? km_fail(error, KM_MEMORY, "out of memory for a drawing") : status;
}

static km_status render(const km_drawing_def *d, page *p, km_picture_format format, km_text *out, km_error *error) {
  km_canvas *canvas;
  if (!(p->width >= size_least && p->height >= size_least))
    return km_fail(error, KM_USAGE, "a drawing of %g x %g points; expected at least %g each", p->width, p->height,
                   size_least);
  km_status status = km_canvas_create(format, p->width, p->height, out, &canvas, error);
  if (status != KM_OK)
    return status;
  draw_page(d, canvas, p, &status, error);
  if (status == KM_OK)
    status = km_canvas_finish(canvas, error);
  km_canvas_free(canvas);
  return status;
}

km_status km_drawing_render(const km_drawing_def *drawing, km_picture_format format, km_text *out, km_error *error) {
  page p = {0};
  km_status status = plan_page(drawing, &p, error);
  if (status == KM_OK)
    status = render(drawing, &p, format, out, error);
  km_text_free(&p.about);
  return status;
}
