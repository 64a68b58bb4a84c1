/* Shortens names to their distinguishing parts. */
#include "report/plot/short_names.h"

#include "base/text.h"

#include <ctype.h>
#include <string.h>

enum { SHORT = 16 }; /* bytes that are short enough as they are */

/* Signs and points belong to numbers, as those of variants. */
static bool is_word(char c) {
  return isalnum((unsigned char)c) || (unsigned char)c >= 0x80 || c == '-' || c == '+' || c == '.';
}

/* Bytes that all names begin with, as far as whole words go. */
static size_t common_start(const char *const *names, int count) {
  size_t common = strlen(names[0]);
  for (int i = 1; i < count; ++i)
    for (size_t k = 0; k < common; ++k)
      if (names[i][k] != names[0][k])
        common = k;
  while (common > 0 && is_word(names[0][common - 1]))
    --common;
  return common;
}

static size_t common_end(const char *const *names, int count) {
  size_t size = strlen(names[0]), common = size;
  for (int i = 1; i < count; ++i) {
    size_t other = strlen(names[i]);
    for (size_t k = 0; k < common; ++k)
      if (k >= other || names[i][other - 1 - k] != names[0][size - 1 - k])
        common = k;
  }
  while (common > 0 && is_word(names[0][size - common]))
    --common;
  return common;
}

void km_short_names(const char *const *names, int count, km_arena *arena, const char **out) {
  size_t start = count > 1 ? common_start(names, count) : 0, end = count > 1 ? common_end(names, count) : 0;
  for (int i = 0; i < count; ++i) {
    size_t size = strlen(names[i]);
    km_text text = {0};
    if (size > SHORT && start + end < size)
      km_text_format(&text, "%s%.*s%s", start ? "…" : "", (int)(size - start - end), names[i] + start, end ? "…" : "");
    else
      km_text_add(&text, names[i]);
    out[i] = km_text_move_to_arena(&text, arena);
  }
}

const char **km_short_names_of(const char *const *first, size_t stride, int count, km_arena *arena) {
  const char **names = KM_ARENA_NEW(arena, const char *, (size_t)count);
  const char **out = KM_ARENA_NEW(arena, const char *, (size_t)count);
  if (arena->failed)
    return NULL;
  for (int i = 0; i < count; ++i)
    memcpy(&names[i], (const char *)first + (size_t)i * stride, sizeof *names);
  km_short_names(names, count, arena, out);
  return arena->failed ? NULL : out;
}
