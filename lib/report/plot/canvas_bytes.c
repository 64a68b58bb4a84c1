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

/* Says 144 dpi in the file, which cairo leaves out: the pHYs chunk (5669 pixels per
 * metre, with its checksum) stands right after the header. */
void km_png_add_resolution(km_text *out, size_t start) {
  static const unsigned char chunk[] = {0,    0, 0, 9,    'p',  'H', 'Y',  's',  0,    0,   0x16,
                                        0x25, 0, 0, 0x16, 0x25, 1,   0x49, 0x52, 0x24, 0xf0};
  const size_t header = 33;
  if (out->size < start + header)
    return;
  km_text_bytes(out, chunk, sizeof chunk);
  if (out->failed)
    return;
  char *place = out->data + start + header;
  memmove(place + sizeof chunk, place, out->size - start - header - sizeof chunk);
  memcpy(place, chunk, sizeof chunk);
}
