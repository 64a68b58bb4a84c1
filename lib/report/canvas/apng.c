/* Joins PNG pictures into an animated one: https://wiki.mozilla.org/APNG_Specification. */
#include "report/canvas/apng.h"

#include "report/canvas/png.h"

#include <stdint.h>
#include <string.h>

enum { SIGNATURE = 8, OVERHEAD = 12, HEADER = 13 }; /* bytes: of the file, around a chunk's data, of IHDR's data */

typedef struct chunk {
  const unsigned char *data;
  uint32_t size;
  char type[5];
} chunk;

static uint32_t number_at(const unsigned char *bytes) {
  return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Reads the chunk at *place and moves behind it; false at the end, or where the bytes are no chunk. */
static bool next_chunk(const km_text *png, size_t *place, chunk *out) {
  const unsigned char *bytes = (const unsigned char *)png->data + *place;
  if (png->size < *place + OVERHEAD || number_at(bytes) > png->size - *place - OVERHEAD)
    return false;
  out->size = number_at(bytes);
  memcpy(out->type, bytes + 4, 4);
  out->type[4] = '\0';
  out->data = bytes + 8;
  *place += OVERHEAD + out->size;
  return true;
}

static void write_animation_control(const km_apng *a) {
  unsigned char data[8] = {0}; /* plays 0: for ever */
  km_png_put_number(data, a->frames);
  km_png_put_chunk(a->out, "acTL", data, 8, data, 0);
}

static void write_frame_control(km_apng *a) {
  unsigned char data[26] = {0}; /* position (0, 0), blending: replace */
  km_png_put_number(data, a->sequence++);
  memcpy(data + 4, a->size, 8);
  data[20] = (unsigned char)(a->milliseconds >> 8);
  data[21] = (unsigned char)a->milliseconds;
  data[22] = 1000 >> 8;
  data[23] = 1000 & 255;
  km_png_put_chunk(a->out, "fcTL", data, 26, data, 0);
}

static void write_image_data(km_apng *a, const chunk *c) {
  unsigned char number[4];
  if (a->added == 0) {
    km_png_put_chunk(a->out, c->type, c->data, 0, c->data, c->size);
    return;
  }
  km_png_put_number(number, a->sequence++);
  km_png_put_chunk(a->out, "fdAT", number, 4, c->data, c->size);
}

/* The first picture gives the file's head. */
static bool write_chunk_of(km_apng *a, const chunk *c, bool *begun) {
  bool image = strcmp(c->type, "IDAT") == 0;
  if (strcmp(c->type, "IHDR") == 0 && c->size == HEADER) {
    if (a->added == 0)
      memcpy(a->size, c->data, 8);
    else if (memcmp(a->size, c->data, 8) != 0)
      return false;
  }
  if (image && !*begun) {
    if (a->added == 0)
      write_animation_control(a);
    write_frame_control(a);
    *begun = true;
  }
  if (image)
    write_image_data(a, c);
  else if (a->added == 0 && !*begun)
    km_png_put_chunk(a->out, c->type, c->data, 0, c->data, c->size);
  return true;
}

km_status km_apng_add(km_apng *a, const km_text *png, km_error *error) {
  static const char signature[] = "\x89PNG\r\n\x1a\n";
  size_t place = SIGNATURE, before = a->out->size;
  chunk c;
  bool good = png->size > SIGNATURE && memcmp(png->data, signature, SIGNATURE) == 0, begun = false;
  if (good && a->added == 0)
    km_text_bytes(a->out, signature, SIGNATURE);
  while (good && next_chunk(png, &place, &c))
    good = write_chunk_of(a, &c, &begun);
  if (!good || !begun) {
    a->out->size = before;
    return km_fail(error, KM_INTERNAL, "picture %u of an animation is no PNG of the first one's size", a->added + 1);
  }
  if (++a->added == a->frames)
    km_png_put_chunk(a->out, "IEND", NULL, 0, NULL, 0);
  return a->out->failed ? km_fail(error, KM_MEMORY, "out of memory for a picture") : KM_OK;
}
