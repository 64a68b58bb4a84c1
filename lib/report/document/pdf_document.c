/* Documents as A4 pages. */
#include "report/document/document.h"

#include "report/canvas/png.h"

#include <math.h>
#include <stdio.h>

static const double page_width = 595.28, page_height = 841.89, margin = 48, foot = 46; /* points */
static const double gap = 10, cell_pad = 3;
static const km_colour black = {0.1, 0.1, 0.1, 1}, grey = {0.42, 0.42, 0.42, 1}, line_colour = {0.8, 0.8, 0.8, 1},
                       shade = {0.95, 0.95, 0.95, 1};

/* State of the layout, which runs twice: the first pass counts the pages. */
typedef struct writer {
  const km_document *document;
  km_canvas *canvas;
  bool drawing; /* else only measured */
  int page, pages;
  double y;
  const km_block *squeezed; /* picture that is drawn lower, so that its section fits on the page; NULL: none */
  double squeezed_by;       /* points */
  km_status status;
  km_error *error;
} writer;

static double text_width(void) {
  return page_width - 2 * margin;
}

static void write(const writer *w, const km_font *font, km_colour colour, const char *text, double x, double y,
                  double across) {
  if (w->drawing)
    km_canvas_text(w->canvas, font, colour, text, (km_canvas_point){x, y}, (km_anchor){across, 0, 0});
}

static double height_of(const writer *w, const km_font *font, const char *text) {
  return km_canvas_measure(w->canvas, font, text).y;
}

static void write_foot(const writer *w) {
  const km_font font = {.size = 7, .width = text_width() - 70};
  char number[40];
  snprintf(number, sizeof number, "page %d of %d", w->page, w->pages);
  double y = page_height - foot + 12;
  if (w->drawing) {
    const km_pen pen = {.colour = line_colour, .width = 0.6};
    km_canvas_line(w->canvas, &pen, (km_canvas_point){margin, y - 5}, (km_canvas_point){page_width - margin, y - 5});
  }
  write(w, &font, grey, w->document->footer, margin, y, 0);
  write(w, &font, grey, number, page_width - margin, y, 1);
}

static void turn_page(writer *w) {
  write_foot(w);
  if (w->drawing)
    km_canvas_page(w->canvas, page_width, page_height);
  w->page++;
  w->y = margin;
}

static double room(const writer *w) {
  return page_height - foot - w->y;
}

static void need(writer *w, double height) {
  if (height > room(w) && w->y > margin)
    turn_page(w);
}

/* Draws the logo in the upper right corner. Returns its size with the distance to the title; 0 without one. */
static km_canvas_point write_logo(const writer *w) {
  static const double most_width = 150, most_height = 44, distance = 14;
  int width, height;
  if (!w->document->logo || km_png_fault(w->document->logo, &width, &height))
    return (km_canvas_point){0, 0};
  const double scale = fmin(most_width / width, most_height / height);
  if (w->drawing)
    km_canvas_pixels(w->canvas, w->document->logo, page_width - margin - scale * width, w->y, scale);
  return (km_canvas_point){scale * width + distance, scale * height};
}

static void write_titles(writer *w) {
  const km_canvas_point logo = write_logo(w);
  const km_font title = {.size = 18, .bold = true, .width = text_width() - logo.x, .lines = 2};
  const km_font subtitle = {.size = 9, .width = text_width() - logo.x, .lines = 3};
  const double top = w->y;
  write(w, &title, black, w->document->title, margin, w->y, 0);
  w->y += height_of(w, &title, w->document->title) + 4;
  write(w, &subtitle, grey, w->document->subtitle, margin, w->y, 0);
  w->y = fmax(w->y + height_of(w, &subtitle, w->document->subtitle), top + logo.y) + 1.6 * gap;
}

static km_font text_font(const km_block *block) {
  return (km_font){.size = block->kind == KM_BLOCK_LEAD ? 11.5 : 9, .width = text_width(), .lines = 40};
}

static void write_text(writer *w, const km_block *block) {
  const km_font font = text_font(block);
  double height = height_of(w, &font, block->text);
  need(w, height);
  write(w, &font, black, block->text, margin, w->y, 0);
  w->y += height + gap;
}

static void write_facts(writer *w, const km_block *block) {
  const double names = 140;
  const km_font name = {.size = 9, .width = names - 8}, fact = {.size = 9, .width = text_width() - names, .lines = 8};
  for (size_t r = 0; r < block->rows; ++r) {
    const char *const *row = block->cells + 2 * r;
    double height = height_of(w, &fact, row[1]);
    need(w, height);
    write(w, &name, grey, row[0], margin, w->y, 0);
    write(w, &fact, black, row[1], margin + names, w->y, 0);
    w->y += height + 3;
  }
  w->y += gap;
}

enum { MOST_COLUMNS = 24 };

/* Widths of the columns, and the font in which they fit. */
static km_font fit_columns(const writer *w, const km_block *block, double width[MOST_COLUMNS]) {
  km_font font = {.size = 8.5};
  for (;; font.size -= 0.5) {
    double total = 0.0;
    for (size_t c = 0; c < block->columns; ++c) {
      width[c] = 0.0;
      for (size_t r = 0; r < block->rows; ++r) {
        font.bold = r == 0;
        width[c] = fmax(width[c], km_canvas_measure(w->canvas, &font, block->cells[r * block->columns + c]).x);
      }
      width[c] += 4 * cell_pad;
      total += width[c];
    }
    if (total <= text_width() || font.size <= 5.0) {
      double spare = fmax(text_width() - total, 0.0) / (double)block->columns;
      for (size_t c = 0; c < block->columns; ++c)
        width[c] += fmin(spare, 30.0);
      return font;
    }
  }
}

static void write_row(writer *w, const km_block *block, size_t r, const double *width, km_font font, double height) {
  double x = margin, total = 0.0;
  for (size_t c = 0; c < block->columns; ++c)
    total += width[c];
  if (r > 0 && r % 2 == 0 && w->drawing)
    km_canvas_rectangle(w->canvas, shade, margin, w->y, total, height);
  font.bold = r == 0;
  for (size_t c = 0; c < block->columns; ++c, x += width[c - 1]) {
    const char *text = block->cells[r * block->columns + c];
    bool first = c == 0;
    write(w, &font, black, text, first ? x + cell_pad : x + width[c] - cell_pad, w->y + cell_pad, first ? 0 : 1);
  }
  if (r == 0 && w->drawing) {
    const km_pen pen = {.colour = black, .width = 0.7};
    km_canvas_line(w->canvas, &pen, (km_canvas_point){margin, w->y + height},
                   (km_canvas_point){margin + total, w->y + height});
  }
  w->y += height;
}

static void write_table(writer *w, const km_block *block) {
  double width[MOST_COLUMNS];
  km_font font = fit_columns(w, block, width);
  double height = height_of(w, &font, "Ag") + 2 * cell_pad;
  need(w, 3 * height);
  for (size_t r = 0; r < block->rows; ++r) {
    if (height > room(w)) {
      turn_page(w);
      write_row(w, block, 0, width, font, height);
    }
    write_row(w, block, r, width, font, height);
  }
  w->y += 1.4 * gap;
}

static void write_picture(writer *w, const km_block *block) {
  const double height = block->height - (block == w->squeezed ? w->squeezed_by : 0.0);
  need(w, height);
  if (w->drawing) {
    km_canvas_shift(w->canvas, margin, w->y);
    w->status = block->draw(block->context, w->canvas, text_width(), height, w->error);
    km_canvas_shift(w->canvas, -margin, -w->y);
  }
  w->y += height + gap;
}

/* A part begins a page. */
static void write_part(writer *w, const km_block *block) {
  const km_font font = {.size = 15, .bold = true, .width = text_width(), .lines = 2};
  if (w->y > margin)
    turn_page(w);
  write(w, &font, black, block->text, margin, w->y, 0);
  w->y += height_of(w, &font, block->text) + gap;
}

/* Height of a block on a page. */
static double block_height(const writer *w, const km_block *block) {
  const km_font paragraph = text_font(block);
  double width[MOST_COLUMNS];
  km_font font;
  switch (block->kind) {
  case KM_BLOCK_LEAD:
  case KM_BLOCK_TEXT:
    return height_of(w, &paragraph, block->text) + gap;
  case KM_BLOCK_TABLE:
    font = fit_columns(w, block, width);
    return (double)block->rows * (height_of(w, &font, "Ag") + 2 * cell_pad) + 1.4 * gap;
  case KM_BLOCK_PICTURE:
  case KM_BLOCK_FILM:
    return block->height + gap;
  default:
    return 15.0 * (double)block->rows;
  }
}

/* True if the section fits on the rest of the page with its first picture at most a third lower, which is noted. */
static bool squeeze(writer *w, const km_block *picture, double section) {
  static const double most = 1.0 / 3.0;
  const double over = section - room(w);
  if (!picture || !(over > 0.0) || over > most * picture->height)
    return false;
  w->squeezed = picture;
  w->squeezed_by = over + gap; /* rounding does not turn the page */
  return true;
}

/* A heading is kept with its complete section if that fits on a page, otherwise with the first block. */
static void write_heading(writer *w, const km_block *block, const km_block *end) {
  const km_font font = {.size = 12, .bold = true, .width = text_width()};
  double height = height_of(w, &font, block->text) + 5, section = height, first = height;
  const km_block *picture = NULL;
  for (const km_block *b = block + 1; b < end && b->kind != KM_BLOCK_HEADING && b->kind != KM_BLOCK_PART; ++b) {
    section += block_height(w, b);
    picture = picture || b->kind != KM_BLOCK_PICTURE ? picture : b;
    if (b == block + 1)
      first += fmin(block_height(w, b), b->kind == KM_BLOCK_PICTURE || b->kind == KM_BLOCK_FILM ? HUGE_VAL : 60.0);
  }
  if (!squeeze(w, picture, section - gap))
    need(w, section <= page_height - margin - foot ? section - gap : first);
  write(w, &font, black, block->text, margin, w->y, 0);
  w->y += height;
}

static void lay_out(writer *w) {
  w->page = 1;
  w->y = margin;
  write_titles(w);
  for (size_t i = 0; i < w->document->count && !w->status; ++i) {
    const km_block *block = &w->document->blocks[i];
    switch (block->kind) {
    case KM_BLOCK_PART:
      write_part(w, block);
      break;
    case KM_BLOCK_HEADING:
      write_heading(w, block, w->document->blocks + w->document->count);
      break;
    case KM_BLOCK_LEAD:
    case KM_BLOCK_TEXT:
      write_text(w, block);
      break;
    case KM_BLOCK_FACTS:
      write_facts(w, block);
      break;
    case KM_BLOCK_TABLE:
      write_table(w, block);
      break;
    case KM_BLOCK_PICTURE:
    case KM_BLOCK_FILM:
      write_picture(w, block);
      break;
    }
  }
  write_foot(w);
}

km_status km_document_pdf(const km_document *document, km_text *out, km_error *error) {
  writer w = {.document = document, .error = error};
  km_status status = km_canvas_create(KM_PICTURE_PDF, page_width, page_height, out, &w.canvas, error);
  if (status)
    return status;
  lay_out(&w);
  w.pages = w.page;
  w.drawing = true;
  lay_out(&w);
  status = w.status ? w.status : km_canvas_finish(w.canvas, error);
  km_canvas_free(w.canvas);
  return status;
}
