/* Blocks of a document in the making. */
#include "report/document/document.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void add(km_document_maker *m, km_block block) {
  if (m->count == m->capacity) {
    size_t capacity = m->capacity ? 2 * m->capacity : 32;
    km_block *blocks = KM_ARENA_NEW(&m->arena, km_block, capacity);
    if (!blocks)
      return;
    if (m->count)
      memcpy(blocks, m->blocks, m->count * sizeof *blocks);
    m->blocks = blocks;
    m->capacity = capacity;
  }
  m->blocks[m->count++] = block;
}

void km_document_heading(km_document_maker *m, const char *text) {
  add(m, (km_block){.kind = KM_BLOCK_HEADING, .text = text});
}

void km_document_part(km_document_maker *m, const char *text) {
  add(m, (km_block){.kind = KM_BLOCK_PART, .text = text});
}

void km_document_lead(km_document_maker *m, const char *text) {
  add(m, (km_block){.kind = KM_BLOCK_LEAD, .text = text});
}

void km_document_text(km_document_maker *m, const char *text) {
  add(m, (km_block){.kind = KM_BLOCK_TEXT, .text = text});
}

void km_document_cells(km_document_maker *m, km_block_kind kind, const char *const *cells, size_t rows,
                       size_t columns) {
  add(m, (km_block){.kind = kind, .cells = cells, .rows = rows, .columns = columns});
}

void km_document_picture(km_document_maker *m, const char *shows, double height,
                         km_status (*draw)(void *, km_canvas *, double, double, km_error *), void *context) {
  add(m, (km_block){.kind = KM_BLOCK_PICTURE, .text = shows, .height = height, .draw = draw, .context = context});
}

void km_document_film(km_document_maker *m, const km_film_page *film, const char *shows, double height,
                      km_status (*draw)(void *, km_canvas *, double, double, km_error *), void *context) {
  add(m, (km_block){
             .kind = KM_BLOCK_FILM, .text = shows, .height = height, .draw = draw, .context = context, .film = film});
}

const char *km_document_words(km_document_maker *m, km_text *text, const char *otherwise) {
  bool none = !text->failed && text->size == 0;
  const char *kept = km_text_move_to_arena(text, &m->arena);
  return none || !kept ? otherwise : kept;
}

const char *km_document_format(km_document_maker *m, const char *format, ...) {
  char text[2048];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  const char *kept = km_arena_string(&m->arena, text);
  return kept ? kept : "";
}
