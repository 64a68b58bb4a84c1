/* Text in simple scripts, letter by letter, in lines. */
#include "report/canvas/letters.h"

#include "base/memory.h"
#include "report/canvas/harfbuzz_library.h"

#include <math.h>
#include <string.h>

static const double pango_rounding = 1.0 / 1024; /* points */

/* Characters written from left to right, each with one glyph in every context. Excluded are combining marks,
 * controls, other directions and pictographs. */
static bool is_simple(uint32_t c) {
  static const uint32_t ranges[][2] = {{0x20, 0x7e},     {0xa0, 0xac},     {0xae, 0x24f},    {0x370, 0x3ff},
                                       {0x400, 0x482},   {0x48a, 0x52f},   {0x1e00, 0x1eff}, {0x2010, 0x2027},
                                       {0x2030, 0x205e}, {0x2070, 0x20bf}, {0x2100, 0x22ff}, {0x25a0, 0x25cf}};
  for (size_t i = 0; i < sizeof ranges / sizeof *ranges; ++i)
    if (c >= ranges[i][0] && c <= ranges[i][1])
      return true;
  return false;
}

/* The character at *text, which then is behind it; 0 where there are no more, or bytes that are no UTF-8 of three bytes
 * or fewer: those that are simple are no longer. */
static uint32_t next_character(const char **text) {
  const unsigned char *s = (const unsigned char *)*text;
  int length = s[0] < 0x80 ? 1 : s[0] >= 0xc2 && s[0] < 0xe0 ? 2 : (s[0] & 0xf0) == 0xe0 ? 3 : 0;
  uint32_t c = length == 1 ? s[0] : s[0] & (length == 2 ? 0x1f : 0x0f);
  for (int i = 1; i < length; ++i) {
    if ((s[i] & 0xc0) != 0x80)
      return 0;
    c = c << 6 | (s[i] & 0x3f);
  }
  if (length == 0 || (length == 3 && c < 0x800))
    return 0;
  *text += length;
  return c;
}

static bool all_simple(const char *text) {
  while (*text)
    if (!is_simple(next_character(&text)))
      return false;
  return true;
}

/* Bytes of the first part of a text that is in one script; signs belong to the script around them. */
static size_t script_run(const km_harfbuzz *lib, const char *text, hb_script_t *script) {
  hb_unicode_funcs_t *unicode = lib->hb_unicode_funcs_get_default();
  const char *end = text;
  *script = HB_SCRIPT_COMMON;
  while (*end) {
    const char *next = end;
    hb_script_t own = lib->hb_unicode_script(unicode, next_character(&next));
    if (own != HB_SCRIPT_COMMON && own != HB_SCRIPT_INHERITED) {
      if (*script != HB_SCRIPT_COMMON && own != *script)
        break;
      *script = own;
    }
    end = next;
  }
  return (size_t)(end - text);
}

static bool reserve(km_letters *l, size_t more) {
  void *items = l->items;
  if (!km_reserve(&items, &l->room, l->count + more, sizeof *l->items))
    l->failed = true;
  l->items = items;
  return !l->failed;
}

/* Adds the letters that the buffer holds. False: the font lacks one, or one isn't on the baseline. */
static bool copy_letters(km_letters *l, const km_harfbuzz *lib, int *x) {
  unsigned count;
  const hb_glyph_info_t *info = lib->hb_buffer_get_glyph_infos(l->buffer, &count);
  const hb_glyph_position_t *position = lib->hb_buffer_get_glyph_positions(l->buffer, &count);
  if (!reserve(l, count))
    return false;
  for (unsigned i = 0; i < count; ++i) {
    if (info[i].codepoint == 0 || position[i].y_offset || position[i].y_advance)
      return false;
    l->items[l->count++] = (km_letter){.glyph = info[i].codepoint,
                                       .byte = info[i].cluster,
                                       .x = *x + position[i].x_offset,
                                       .advance = position[i].x_advance};
    *x += position[i].x_advance;
  }
  return true;
}

static bool shape_run(km_letters *l, const km_faces *f, size_t begin, size_t size, hb_script_t script, int *x) {
  const km_harfbuzz *lib = f->lib;
  lib->hb_buffer_clear_contents(l->buffer);
  lib->hb_buffer_add_utf8(l->buffer, l->text, -1, (unsigned)begin, (int)size);
  lib->hb_buffer_set_direction(l->buffer, HB_DIRECTION_LTR);
  lib->hb_buffer_set_script(l->buffer, script);
  lib->hb_buffer_set_language(l->buffer, lib->hb_language_from_string("en", -1));
  lib->hb_shape(f->faces[l->bold].font, l->buffer, NULL, 0);
  l->failed = l->failed || !lib->hb_buffer_allocation_successful(l->buffer);
  return !l->failed && copy_letters(l, lib, x);
}

/* All letters, as in one line. */
static bool shape(km_letters *l, const km_faces *f) {
  int x = 0;
  if (!l->buffer)
    l->buffer = f->lib->hb_buffer_create();
  l->count = 0;
  for (size_t at = 0; l->text[at];) {
    hb_script_t script;
    size_t size = script_run(f->lib, l->text + at, &script);
    if (!shape_run(l, f, at, size, script, &x))
      return false;
    at += size;
  }
  return true;
}

static int end_of(const km_letter *letter) {
  return letter->x + letter->advance;
}

static void add_line(km_letters *l, size_t first, size_t end) {
  void *lines = l->lines;
  if (!km_reserve(&lines, &l->line_room, l->line_count + 1, sizeof *l->lines))
    l->failed = true;
  l->lines = lines;
  if (l->failed)
    return;
  int from = first < end ? l->items[first].x : 0;
  size_t begin = first < end ? l->items[first].byte : 0;
  size_t behind = end < l->count ? l->items[end].byte : strlen(l->text);
  double width = first < end ? l->unit * (end_of(&l->items[end - 1]) - from) : 0.0;
  for (size_t i = first; i < end; ++i)
    l->items[i].x -= from;
  l->lines[l->line_count++] = (km_letters_line){begin, behind - begin, first, end - first, width};
  l->width = fmax(l->width, width);
}

static unsigned char byte_of(const km_letters *l, size_t i) {
  return i < l->count ? (unsigned char)l->text[l->items[i].byte] : '\0';
}

static bool is_blank(const km_letters *l, size_t i) {
  return byte_of(l, i) == ' ';
}

static bool is_latin(const km_letters *l, size_t i) {
  unsigned char small = byte_of(l, i) | 32;
  return small >= 'a' && small <= 'z';
}

static bool is_digit(const km_letters *l, size_t i) {
  return byte_of(l, i) >= '0' && byte_of(l, i) <= '9';
}

/* The width of a letter that has no neighbour on its right. */
static int own_advance(const km_letters *l, uint32_t glyph) {
  const km_faces *f = km_faces_find();
  return f->lib->hb_font_get_glyph_h_advance(f->faces[l->bold].font, glyph);
}

/* Line break after letter i by the rules of Unicode. Characters that need further rules are left to Pango: U+2010 to
 * U+2027 are dashes, dots, daggers and quotation marks. */
typedef enum line_break { NO_BREAK, MAY_BREAK, DOUBTFUL } line_break;

static line_break break_behind(const km_letters *l, size_t word, size_t i) {
  unsigned char c = byte_of(l, i);
  if (c == '-' || c == '/')
    return i > word && (is_latin(l, i - 1) || is_digit(l, i - 1)) && is_latin(l, i + 1) ? MAY_BREAK : DOUBTFUL;
  const unsigned char *bytes = (const unsigned char *)l->text + l->items[i].byte;
  if (c == 0xe2 && bytes[1] == 0x80)
    return bytes[2] >= 0x98 && bytes[2] <= 0x9f ? NO_BREAK : DOUBTFUL;
  return strchr("!?{|}", c) ? DOUBTFUL : NO_BREAK;
}

/* Letters that stay on one line, and where the next ones begin. */
typedef struct word {
  size_t end, next;
  bool doubtful; /* a line might end inside */
} word;

static word word_from(const km_letters *l, size_t begin) {
  word w = {begin, begin, false};
  for (; w.end < l->count && !is_blank(l, w.end); ++w.end) {
    line_break after = break_behind(l, begin, w.end);
    w.doubtful = w.doubtful || after == DOUBTFUL;
    if (after == MAY_BREAK) {
      l->items[w.end].advance = own_advance(l, l->items[w.end].glyph);
      return (word){w.end + 1, w.end + 1, w.doubtful};
    }
  }
  for (w.next = w.end; is_blank(l, w.next);)
    ++w.next;
  w.doubtful = w.doubtful || w.next > w.end + 1; /* Pango drops one blank, not all */
  return w;
}

static bool fits(const km_letters *l, size_t first, size_t end, double most) {
  return end <= first || l->unit * (end_of(&l->items[end - 1]) - l->items[first].x) <= most + pango_rounding;
}

/* Puts a letter of dots in the place of those from `begin` to `end`, of which there is one at least. */
static void write_dots(km_letters *l, size_t begin, size_t end, km_letter dots) {
  dots.byte = l->items[begin].byte;
  dots.x = l->items[begin].x;
  int shift = end_of(&dots) - end_of(&l->items[end - 1]);
  l->items[begin] = dots;
  for (size_t i = end; i < l->count; ++i) {
    l->items[begin + 1 + i - end] = l->items[i];
    l->items[begin + 1 + i - end].x += shift;
  }
  l->count -= end - begin - 1;
}

/* All letters from `first` on as one line, with dots for as many in the middle as it takes. The gap grows as
 * Pango's, to the side where it stays nearer to the middle, and its dots take up what is left of the width. */
static bool shorten(km_letters *l, size_t first, double most) {
  const km_faces *faces = km_faces_find();
  const km_face *face = &faces->faces[l->bold];
  km_letter dots = {0};
  if (!faces->lib->hb_font_get_nominal_glyph(face->font, 0x2026, &dots.glyph))
    return false;
  dots.advance = own_advance(l, dots.glyph);
  int left = l->items[first].x, right = end_of(&l->items[l->count - 1]), middle = left + (right - left) / 2;
  size_t begin = first;
  while (end_of(&l->items[begin]) <= middle)
    ++begin;
  size_t end = begin + 1;
  for (;;) {
    int from = l->items[begin].x, to = end_of(&l->items[end - 1]);
    int spare = (int)floor((most + pango_rounding) / l->unit) - (right - left - (to - from) + dots.advance);
    if (spare >= 0) {
      dots.advance += spare;
      break;
    }
    if (begin == first && end == l->count)
      return false;
    if (end == l->count || (begin > first && middle - l->items[begin - 1].x < end_of(&l->items[end]) - middle))
      --begin;
    else
      ++end;
  }
  write_dots(l, begin, end, dots);
  add_line(l, first, l->count);
  return !l->failed;
}

/* Parts the letters into lines no wider than `most` points. False where they don't fit. */
static bool wrap(km_letters *l, double most, size_t most_lines) {
  size_t first = 0;
  word last = {0, 0, false};
  for (size_t at = 0; at < l->count; at = last.next) {
    word w = word_from(l, at);
    if (!fits(l, first, w.end, most)) {
      if (l->line_count + 1 >= most_lines)
        return shorten(l, first, most);
      if (at == first || last.doubtful || w.doubtful || !fits(l, at, w.end, most))
        return false;
      add_line(l, first, last.end);
      first = at;
    }
    last = w;
  }
  add_line(l, first, l->count);
  return !l->failed;
}

bool km_letters_set(km_letters *letters, const km_font *font, const char *text) {
  const km_faces *faces = km_faces_find();
  if (!faces || !all_simple(text))
    return false;
  letters->text = text;
  letters->bold = font->bold;
  letters->unit = font->size / faces->faces[font->bold].units;
  letters->line_count = 0;
  letters->width = 0.0;
  return shape(letters, faces) &&
         wrap(letters, font->width > 0 ? font->width : HUGE_VAL, font->lines > 1 ? (size_t)font->lines : 1);
}

void km_letters_free(km_letters *letters) {
  if (letters->buffer)
    km_faces_find()->lib->hb_buffer_destroy(letters->buffer);
  km_free(letters->items);
  km_free(letters->lines);
  *letters = (km_letters){0};
}

void km_letters_outline(bool bold, uint32_t glyph, km_canvas_path *path) {
  const km_faces *faces = km_faces_find();
  if (faces)
    faces->lib->hb_font_get_glyph_shape(faces->faces[bold].font, glyph, faces->draw, path);
}

const char *km_letters_file(bool bold) {
  const km_faces *faces = km_faces_find();
  return faces ? faces->faces[bold].file : NULL;
}
