/* PNG files of pixels: cairo's own writer tries every filter on every line, which takes three times as long for
 * drawings, whose files it makes no smaller. */
#include "report/canvas/png.h"

#include "base/dynamic_library.h"
#include "base/memory.h"

#include <string.h>
#include <zlib.h>

/* Faster levels are no faster here, higher ones take twice as long for a tenth of the size. */
enum { LEVEL = 3 };

/* Functions of zlib, which cairo has loaded. */
typedef struct zip {
  __typeof__(&compressBound) bound;
  __typeof__(&compress2) compress;
} zip;

/* NULL where it can't be had. */
static const zip *load(void) {
  static const char *const files[] = {"libz.so.1", NULL}, *const names[] = {"compressBound", "compress2", NULL};
  static zip functions;
  static km_library library = {files, names, &functions, false};
  return km_library_load(&library) ? NULL : &functions;
}

void km_png_put_number(unsigned char *at, uint32_t value) {
  for (int i = 0; i < 4; ++i)
    at[i] = (unsigned char)(value >> (24 - 8 * i));
}

/* The cyclic redundancy check of ISO 3309, continued by four bits at a time. */
static uint32_t check(uint32_t sum, const unsigned char *bytes, size_t size) {
  static const uint32_t table[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4,
                                     0x4db26158, 0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                     0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
  for (size_t i = 0; i < size; ++i) {
    sum = table[(sum ^ bytes[i]) & 15] ^ sum >> 4;
    sum = table[(sum ^ (uint32_t)(bytes[i] >> 4)) & 15] ^ sum >> 4;
  }
  return sum;
}

void km_png_put_chunk(km_text *out, const char *type, const unsigned char *head, uint32_t head_size,
                      const unsigned char *data, uint32_t size) {
  unsigned char number[4];
  uint32_t sum = check(UINT32_MAX, (const unsigned char *)type, 4);
  sum = check(check(sum, head, head_size), data, size);
  km_png_put_number(number, head_size + size);
  km_text_bytes(out, number, 4);
  km_text_bytes(out, type, 4);
  km_text_bytes(out, head, head_size);
  km_text_bytes(out, data, size);
  km_png_put_number(number, ~sum);
  km_text_bytes(out, number, 4);
}

static void write_header(km_text *out, const km_pixels *p) {
  static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  unsigned char header[13] = {0}, resolution[9] = {0};
  km_png_put_number(header, (uint32_t)p->width);
  km_png_put_number(header + 4, (uint32_t)p->height);
  header[8] = 8; /* bits of a colour */
  header[9] = 2; /* red, green, blue */
  km_png_put_number(resolution, p->per_metre);
  km_png_put_number(resolution + 4, p->per_metre);
  resolution[8] = 1; /* the unit is the metre */
  km_text_bytes(out, signature, sizeof signature);
  km_png_put_chunk(out, "IHDR", header, sizeof header, header, 0);
  km_png_put_chunk(out, "pHYs", resolution, sizeof resolution, resolution, 0);
}

/* Lines of red, green, blue behind a byte that says that none is filtered. */
static void copy_lines(const km_pixels *p, unsigned char *to) {
  for (int y = 0; y < p->height; ++y) {
    const uint32_t *from = (const uint32_t *)(const void *)(p->data + (size_t)y * (size_t)p->stride);
    *to++ = 0;
    for (int x = 0; x < p->width; ++x) {
      *to++ = (unsigned char)(from[x] >> 16);
      *to++ = (unsigned char)(from[x] >> 8);
      *to++ = (unsigned char)from[x];
    }
  }
}

bool km_png_write(const km_pixels *p, km_text *out) {
  const zip *z = load();
  if (!z)
    return false;
  size_t size = (size_t)p->height * (3 * (size_t)p->width + 1);
  uLongf packed = z->bound((uLong)size);
  unsigned char *lines = KM_NEW(unsigned char, size), *data = KM_NEW(unsigned char, packed);
  bool written = lines && data;
  if (written) {
    copy_lines(p, lines);
    written = z->compress(data, &packed, lines, (uLong)size, LEVEL) == Z_OK;
  }
  if (written) {
    write_header(out, p);
    km_png_put_chunk(out, "IDAT", data, 0, data, (uint32_t)packed);
    km_png_put_chunk(out, "IEND", data, 0, data, 0);
  }
  km_free(lines);
  km_free(data);
  return written && !out->failed;
}

static uint32_t get_number(const unsigned char *at) {
  return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

const char *km_png_fault(const km_text *png, int *width, int *height) {
  static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const unsigned char *at = (const unsigned char *)png->data;
  size_t left = png->size;
  bool has_head = false, has_data = false;
  *width = *height = 0;
  if (left < sizeof signature || memcmp(at, signature, sizeof signature) != 0)
    return "it isn't a PNG picture";
  at += sizeof signature;
  left -= sizeof signature;
  /* A chunk: four bytes of length n, four of type, n of data, four of the check sum of type and data. */
  while (left >= 12) {
    const uint32_t size = get_number(at);
    if (size > left - 12)
      break;
    if (get_number(at + 8 + size) != (uint32_t)~check(UINT32_MAX, at + 4, size + 4))
      return "a part of it is damaged";
    if (memcmp(at + 4, "IHDR", 4) == 0 && size == 13 && !has_head) {
      const uint32_t w = get_number(at + 8), h = get_number(at + 12);
      if (w == 0 || h == 0 || w > KM_PNG_MOST || h > KM_PNG_MOST)
        return "it is more than 4096 pixels wide or high, or empty";
      *width = (int)w;
      *height = (int)h;
      has_head = true;
    }
    has_data = has_data || memcmp(at + 4, "IDAT", 4) == 0;
    if (memcmp(at + 4, "IEND", 4) == 0)
      return has_head && has_data ? NULL : "a part of it is missing";
    at += size + 12;
    left -= size + 12;
  }
  return "its end is missing";
}
