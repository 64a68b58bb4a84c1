/* Documents: headings, facts, tables and pictures, as PDF pages or one self-contained HTML file. Knows nothing of
 * mechanisms. */
#ifndef KM_REPORT_DOCUMENT_DOCUMENT_H
#define KM_REPORT_DOCUMENT_DOCUMENT_H

#include "base/memory.h"
#include "report/canvas/canvas.h"
#include "report/document/film_page.h"

typedef enum km_block_kind {
  KM_BLOCK_LEAD, /* the answer, before anything else */
  KM_BLOCK_PART, /* title of a part, which begins a page */
  KM_BLOCK_HEADING,
  KM_BLOCK_TEXT,
  KM_BLOCK_FACTS, /* rows of a name and what it is */
  KM_BLOCK_TABLE, /* the first row is the head */
  KM_BLOCK_PICTURE,
  KM_BLOCK_FILM /* plays in HTML; a picture on a page */
} km_block_kind;

/* A part of a document. Everything is borrowed. */
typedef struct km_block {
  km_block_kind kind;
  const char *text;         /* text of a title, heading or paragraph; alternative text of a picture */
  const char *const *cells; /* [rows × columns], row by row */
  size_t rows, columns;
  double height; /* height of a picture in points; its width is that of the text */
  km_status (*draw)(void *context, km_canvas *canvas, double width, double height, km_error *error);
  void *context;
  const km_film_page *film; /* films and controls of a KM_BLOCK_FILM, one in a document */
} km_block;

typedef struct km_document {
  const char *title, *subtitle;
  const km_text *logo; /* a PNG file; NULL: none */
  const char *footer;  /* footer of every page */
  const km_block *blocks;
  size_t count;
} km_document;

/* Appends the bytes; the same document gives the same bytes. KM_MEMORY, KM_INTERNAL and what pictures give. */
km_status km_document_pdf(const km_document *document, km_text *out, km_error *error);
km_status km_document_html(const km_document *document, km_text *out, km_error *error);

/* Blocks in the making. */
typedef struct km_document_maker {
  km_arena arena;
  km_block *blocks; /* [count] in the arena */
  size_t count, capacity;
  const struct km_plot_over *over; /* axis of all plots in place of their own; NULL: their own */
} km_document_maker;

void km_document_part(km_document_maker *maker, const char *text);
void km_document_lead(km_document_maker *maker, const char *text);
void km_document_heading(km_document_maker *maker, const char *text);
void km_document_text(km_document_maker *maker, const char *text);
void km_document_cells(km_document_maker *maker, km_block_kind kind, const char *const *cells, size_t rows,
                       size_t columns);
void km_document_picture(km_document_maker *maker, const char *shows, double height,
                         km_status (*draw)(void *, km_canvas *, double, double, km_error *), void *context);
/* A film; `draw` makes its picture on a page. */
void km_document_film(km_document_maker *maker, const km_film_page *film, const char *shows, double height,
                      km_status (*draw)(void *, km_canvas *, double, double, km_error *), void *context);
/* The text's words, kept in the arena, or `otherwise` where there are none; frees the text. */
const char *km_document_words(km_document_maker *maker, km_text *text, const char *otherwise);
/* Text in the maker's arena. */
const char *km_document_format(km_document_maker *maker, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
