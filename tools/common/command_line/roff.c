/* Writes text for manual pages: nothing in it is taken for a request of roff. */
#include "common/command_line/roff.h"

#include <string.h>

/* The code point at *text, which moves behind it. */
static unsigned next_point(const char **text) {
  const unsigned char *c = (const unsigned char *)*text;
  int more = *c < 0xC0 ? 0 : *c < 0xE0 ? 1 : *c < 0xF0 ? 2 : 3;
  unsigned point = *c & (more == 0 ? 0x7Fu : 0x3Fu >> more);
  for (++c; more > 0 && *c; --more)
    point = point << 6 | (*c++ & 0x3Fu);
  *text = (const char *)c;
  return point;
}

void kt_roff(const char *text, size_t length, km_text *out) {
  static const char special[] = "\\-'`^~";
  static const char *const escapes[] = {"\\e", "\\-", "\\(aq", "\\(ga", "\\(ha", "\\(ti"};
  const char *end = text + length;
  if (length && *text == '.')
    km_text_add(out, "\\&");
  while (text < end) {
    unsigned point = next_point(&text);
    const char *found = point < 0x80 ? strchr(special, (int)point) : NULL;
    if (found)
      km_text_add(out, escapes[found - special]);
    else if (point < 0x80)
      km_text_format(out, "%c", (int)point);
    else
      km_text_format(out, "\\[u%04X]", point);
  }
}

typedef struct cell {
  const char *text;
  size_t length;
} cell;

/* The cells of "| a | b |", without the blanks around them; how many there are, at most `most`. */
static int cut_row(const char *row, size_t length, cell *cells, int most) {
  const char *at = row + 1, *end = row + length;
  int count = 0;
  while (count < most && at < end) {
    const char *bar = memchr(at, '|', (size_t)(end - at)), *last = bar ? bar : end;
    while (at < last && *at == ' ')
      ++at;
    const char *behind = last;
    while (behind > at && behind[-1] == ' ')
      --behind;
    cells[count++] = (cell){at, (size_t)(behind - at)};
    at = bar ? bar + 1 : end;
  }
  return count;
}

/* Writes a text without the backquotes of names. */
static void write_cell(cell c, km_text *out) {
  while (c.length) {
    const char *quote = memchr(c.text, '`', c.length);
    size_t length = quote ? (size_t)(quote - c.text) : c.length;
    kt_roff(c.text, length, out);
    c.text += length + (quote != NULL);
    c.length -= length + (quote != NULL);
  }
}

/* Key, shape, unit, what counts without it, meaning. */
static void write_key(const char *row, size_t length, km_text *out) {
  enum { KEY, SHAPE, UNIT, WITHOUT, MEANING, CELLS };
  cell cells[CELLS];
  if (length < 3 || row[2] != '`' || cut_row(row, length, cells, CELLS) < CELLS) /* the table's head */
    return;
  bool required = cells[WITHOUT].length == strlen("required") && memcmp(cells[WITHOUT].text, "required", 8) == 0;
  km_text_add(out, ".TP\n\\fB");
  write_cell(cells[KEY], out);
  km_text_add(out, "\\fR (");
  write_cell(cells[SHAPE], out);
  if (cells[UNIT].length)
    km_text_add(out, "; unit ");
  write_cell(cells[UNIT], out);
  if (cells[WITHOUT].length)
    km_text_add(out, required ? "; " : "; without it ");
  write_cell(cells[WITHOUT], out);
  km_text_add(out, ")\n");
  write_cell(cells[MEANING], out);
  km_text_add(out, "\n");
}

void kt_roff_keys(const char *markdown, km_text *out) {
  static const char mark[] = "<!-- keys: ";
  for (const char *line = markdown; *line;) {
    size_t length = strcspn(line, "\n");
    if (strncmp(line, mark, sizeof mark - 1) == 0) {
      km_text_add(out, ".SS Keys of ");
      kt_roff(line + sizeof mark - 1, strcspn(line + sizeof mark - 1, " "), out);
      km_text_add(out, "\n");
    } else if (*line == '|') {
      write_key(line, length, out);
    }
    line += length + (line[length] != '\0');
  }
}
