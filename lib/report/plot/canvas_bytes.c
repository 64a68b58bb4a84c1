/* Changes the bytes of finished pictures where the graphics library leaves something to wish for. */
#include "report/plot/canvas_bytes.h"

#include <string.h>

/* Cairo names the page after a counter of the process ("surface12"), which nothing refers to. */
void km_svg_drop_id(km_text *out, size_t start) {
  static const char key[] = " id=\"surface";
  char *found = strstr(out->data + start, key);
  char *end = found ? strchr(found + sizeof key - 1, '"') : NULL;
  if (!end)
    return;
  size_t cut = (size_t)(end + 1 - found);
  memmove(found, end + 1, out->size + 1 - (size_t)(end + 1 - out->data));
  out->size -= cut;
}
