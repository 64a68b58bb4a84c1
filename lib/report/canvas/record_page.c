/* Pages that pass each element to a recorder instead of drawing it. */
#include "base/text.h"
#include "report/canvas/canvas_device.h"
#include "report/canvas/svg_path.h"

typedef struct record_page {
  const km_canvas_recorder *recorder;
} record_page;

static void record_shape(void *context, const km_canvas_path *path, const km_colour *fill, const km_pen *pen) {
  const km_canvas_recorder *recorder = ((record_page *)context)->recorder;
  km_text text = {0};
  km_text_add(&text, "");
  km_svg_path_write(&text, path, recorder->decimals, recorder->slack);
  recorder->shape(recorder->context, text.failed ? NULL : text.data, fill, pen);
  km_text_free(&text);
}

static void record_text(void *context, const char *text, size_t size, const km_font *font, km_colour colour,
                        const km_text_place *place, double width) {
  const km_canvas_recorder *recorder = ((record_page *)context)->recorder;
  km_text line = {0};
  km_text_bytes(&line, text, size);
  recorder->line(recorder->context, line.failed ? NULL : line.data, font, colour, place->at, width, place->angle);
  km_text_free(&line);
}

static void record_line(void *context, const km_letters *letters, size_t line, const km_font *font, km_colour colour,
                        const km_text_place *place) {
  const km_letters_line *l = &letters->lines[line];
  record_text(context, letters->text + l->begin, l->size, font, colour, place, l->width);
}

/* A line of Pango with its position. */
typedef struct shown_layout {
  void *page;
  const km_pango *pango;
  const km_font *font;
  km_colour colour;
  const km_text_place *corner;
} shown_layout;

static void copy_line(void *context, const km_pango_line *line) {
  const shown_layout *s = context;
  const km_text_place place = {km_text_point(s->corner, line->x, line->baseline), s->corner->angle};
  record_text(s->page, km_pango_string(s->pango) + line->begin, line->size, s->font, s->colour, &place, line->width);
}

static void record_layout(void *page, km_pango *pango, const km_font *font, km_colour colour,
                          const km_text_place *place) {
  shown_layout shown = {page, pango, font, colour, place};
  km_pango_lines(pango, copy_line, &shown);
}

static void clip(void *page, double x, double y, double width, double height) {
  (void)page, (void)x, (void)y, (void)width, (void)height;
}

static void release(void *page) {
  (void)page;
}

static bool next(void *page, double width, double height) {
  (void)page, (void)width, (void)height;
  return false;
}

static km_status finish(void *page, km_error *error) {
  (void)page, (void)error;
  return KM_OK;
}

const km_device km_record_device = {record_shape, record_line, record_layout, NULL,   clip,
                                    release,      next,        finish,        km_free};

km_status km_record_page_create(const km_canvas_recorder *recorder, void **page, km_error *error) {
  record_page *made = KM_NEW(record_page, 1);
  *page = made;
  if (!made)
    return km_fail(error, KM_MEMORY, "out of memory for a page");
  made->recorder = recorder;
  return KM_OK;
}
