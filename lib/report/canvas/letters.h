/* Text in simple scripts, shaped by HarfBuzz with the files of the default font: Latin, Greek, Cyrillic, digits,
 * signs, arrows. It needs neither Pango nor fontconfig, whose start takes longer than a picture. Any other text is
 * Pango's, and what fits is set by both to the same places. Private to report/. */
#ifndef KM_REPORT_CANVAS_LETTERS_H
#define KM_REPORT_CANVAS_LETTERS_H

#include "report/canvas/canvas_path.h"

#include <stdint.h>

/* The font's ascent and height in em. Single lines are placed by these, whatever font a foreign script falls back
 * to, so that names of different scripts share a baseline. */
#define KM_FONT_ASCENT 0.928
#define KM_FONT_HEIGHT 1.164

typedef struct km_letter {
  uint32_t glyph; /* glyph index in the font file */
  uint32_t byte;  /* byte of the text at which its character begins */
  int x, advance; /* font units, from the beginning of its line */
} km_letter;

typedef struct km_letters_line {
  size_t begin, size;  /* bytes of the text */
  size_t first, count; /* letters */
  double width;        /* points */
} km_letters_line;

/* A text that is set. Start from {0}. */
typedef struct km_letters {
  const char *text; /* borrowed from the caller of the last request */
  bool bold;
  double unit;  /* points of a font unit */
  double width; /* points, of the longest line */
  km_letter *items;
  km_letters_line *lines;
  size_t count, room, line_count, line_room;
  void *buffer; /* HarfBuzz's */
  bool failed;  /* memory ran out */
} km_letters;

/* Sets the text in lines. False: it needs Pango (scripts, characters that the font lacks, words that don't fit), or
 * memory ran out. */
bool km_letters_set(km_letters *letters, const km_font *font, const char *text);
void km_letters_free(km_letters *letters);

/* Adds the outline of a glyph, in font units, y down. Blanks have none. */
void km_letters_outline(bool bold, uint32_t glyph, km_canvas_path *path);
/* The font's file; NULL where km_letters_set never succeeds. */
const char *km_letters_file(bool bold);

#endif
