/* PNG files of pixels. */
#include "report/plot/png.h"

#include "report/plot/pack.h"

void km_png_put_number(unsigned char *at, uint32_t value) {
  for (int i = 0; i < 4; ++i)
    at[i] = (unsigned char)(value >> (24 - 8 * i));
}

/* Remainders of the cyclic redundancy check of ISO 3309, by the byte that is shifted out. */
static void fill_remainders(uint32_t table[256]) {
  for (uint32_t i = 0; i < 256; ++i) {
    table[i] = i;
    for (int bit = 0; bit < 8; ++bit)
      table[i] = table[i] >> 1 ^ (table[i] & 1 ? 0xedb88320 : 0);
  }
}

static uint32_t check(const uint32_t table[256], uint32_t sum, const unsigned char *bytes, size_t size) {
  for (size_t i = 0; i < size; ++i)
    sum = table[(sum ^ bytes[i]) & 255] ^ sum >> 8;
  return sum;
}

void km_png_put_chunk(km_text *out, const char *type, const unsigned char *head, uint32_t head_size,
                      const unsigned char *data, uint32_t size) {
  unsigned char number[4];
  uint32_t table[256];
  fill_remainders(table);
  uint32_t sum = check(table, UINT32_MAX, (const unsigned char *)type, 4);
  sum = check(table, check(table, sum, head, head_size), data, size);
  km_png_put_number(number, head_size + size);
  km_text_bytes(out, number, 4);
  km_text_bytes(out, type, 4);
  km_text_bytes(out, head, head_size);
  km_text_bytes(out, data, size);
  km_png_put_number(number, ~sum);
  km_text_bytes(out, number, 4);
}

static void put_header(km_text *out, const km_pixels *p) {
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

bool km_png_write(const km_pixels *p, km_text *out) {
  km_text packed = {0};
  bool written = km_pack_pixels(p, &packed);
  const unsigned char *data = (const unsigned char *)packed.data;
  if (written) {
    put_header(out, p);
    km_png_put_chunk(out, "IDAT", data, 0, data, (uint32_t)packed.size);
    km_png_put_chunk(out, "IEND", data, 0, data, 0);
  }
  km_text_free(&packed);
  return written && !out->failed;
}
