/* PNG files of pixels, read again chunk by chunk with zlib: checksums, header, and every pixel. */
#include "base/memory.h"
#include "report/plot/huffman.h"
#include "report/plot/png.h"
#include "support/support.h"

#include <math.h>
#include <string.h>
#include <zlib.h>

static uint32_t number_at(const unsigned char *bytes) {
  return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* The data of the next chunk, which has to be of this type. */
static const unsigned char *next(const km_text *file, size_t *place, const char *type, uint32_t *size) {
  const unsigned char *at = (const unsigned char *)file->data + *place;
  assert_true(*place + 12 <= file->size);
  *size = number_at(at);
  assert_true(*place + 12 + *size <= file->size);
  assert_memory_equal(at + 4, type, 4);
  assert_int_equal(number_at(at + 8 + *size), crc32(0, at + 4, 4 + *size));
  *place += 12 + *size;
  return at + 8;
}

static void check_lines(const unsigned char *data, uint32_t size, const km_pixels *p) {
  uLongf count = (uLongf)p->height * (3 * (uLongf)p->width + 1), expected = count;
  unsigned char *lines = KM_NEW(unsigned char, count);
  assert_int_equal(uncompress(lines, &count, data, size), Z_OK);
  assert_int_equal(count, expected);
  const unsigned char *at = lines;
  for (int y = 0; y < p->height; ++y) {
    const uint32_t *line = (const uint32_t *)(const void *)(p->data + (size_t)y * (size_t)p->stride);
    assert_int_equal(*at++, 0);
    for (int x = 0; x < p->width; ++x, at += 3)
      assert_int_equal(at[0] << 16 | at[1] << 8 | at[2], line[x] & 0xffffff);
  }
  km_free(lines);
}

/* Writes a picture and reads it again. Returns the bytes of its pixels. */
static uint32_t check(const uint32_t *pixels, int width, int height) {
  km_text file = {0};
  uint32_t size, packed;
  const km_pixels picture = {(const unsigned char *)pixels, width, height, width * 4, 5669};
  assert_true(km_png_write(&picture, &file));
  assert_memory_equal(file.data, "\x89PNG\r\n\x1a\n", 8);
  size_t place = 8;
  const unsigned char *data = next(&file, &place, "IHDR", &size);
  assert_int_equal(size, 13);
  assert_int_equal(number_at(data), width);
  assert_int_equal(number_at(data + 4), height);
  data = next(&file, &place, "pHYs", &size);
  assert_int_equal(number_at(data), 5669);
  data = next(&file, &place, "IDAT", &packed);
  check_lines(data, packed, &picture);
  next(&file, &place, "IEND", &size);
  assert_int_equal(size, 0);
  assert_int_equal(place, file.size);
  km_text_free(&file);
  return packed;
}

enum { MOST = 1 << 18 };

static void noise_comes_back(void **state) {
  (void)state;
  randomness r = {3};
  uint32_t *pixels = KM_NEW(uint32_t, MOST);
  for (int i = 0; i < MOST; ++i)
    pixels[i] = (uint32_t)below(&r, 1 << 24);
  static const int sizes[][2] = {{1, 1}, {2, 1}, {1, 3}, {37, 23}, {512, 512}, {28800, 5}};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
    check(pixels, sizes[i][0], sizes[i][1]);
  km_free(pixels);
}

/* Blank paper, stripes, steps, lines that repeat, shapes in few colours: in lines of up to 200 inches, beyond what a
 * repetition reaches. The byte beside the colour is anything. */
static void drawings_come_back_small(void **state) {
  (void)state;
  randomness r = {5};
  uint32_t *pixels = KM_NEW(uint32_t, MOST);
  for (int trial = 0; trial < 60; ++trial) {
    int width = 1 + below(&r, trial % 10 == 9 ? 28800 : 900),
        height = 1 + below(&r, MOST / width > 400 ? 400 : MOST / width);
    int kind = trial % 6, period = 1 + below(&r, 40);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        uint32_t value = kind == 0   ? 0xffffff
                         : kind == 1 ? (uint32_t)(x / period) * 0x10305
                         : kind == 2 ? (uint32_t)(y / period) * 0x10305
                         : kind == 3 ? (uint32_t)(x * x + y * y) / 1000 % 3 * 0x335577
                         : kind == 4 ? (uint32_t)(x % period) * 0x2468a
                                     : (uint32_t)below(&r, 3) * 0x7f7f7f;
        pixels[y * width + x] = (value & 0xffffff) | (uint32_t)below(&r, 256) << 24;
      }
    uint32_t size = check(pixels, width, height);
    assert_true(kind > 2 || height < 20 || size < 1200 + 6 * (uint32_t)width + (uint32_t)(width * height) / 20);
  }
  km_free(pixels);
}

/* No code begins another, none is left over (Kraft's sum is 1), rarer symbols have no shorter ones, by the
 * numbers that were made more alike for the longest of them. */
static void check_code(const unsigned *occurs, int count) {
  km_alphabet a = {.count = count};
  double sum = 0.0;
  memcpy(a.occurs, occurs, (size_t)count * sizeof *occurs);
  km_alphabet_code(&a);
  for (int s = 0; s < count; ++s) {
    assert_true((a.size[s] > 0) == (occurs[s] > 0) && a.size[s] <= KM_CODE_BITS);
    sum += occurs[s] ? ldexp(1.0, -a.size[s]) : 0.0;
    for (int t = 0; t < count; ++t) {
      assert_true(!occurs[s] || !occurs[t] || a.occurs[s] <= a.occurs[t] || a.size[s] <= a.size[t]);
      assert_true(s == t || !a.size[s] || a.size[s] > a.size[t] || (a.bits[t] & ((1U << a.size[s]) - 1)) != a.bits[s]);
    }
  }
  assert_true(sum == 1.0);
}

/* Numbers of Fibonacci would have codes of up to 28 bits. */
static void codes_are_whole(void **state) {
  (void)state;
  randomness r = {7};
  unsigned fibonacci[30] = {1, 1}, some[KM_SYMBOLS];
  for (int i = 2; i < 30; ++i)
    fibonacci[i] = fibonacci[i - 1] + fibonacci[i - 2];
  for (int count = 2; count <= 30; ++count)
    check_code(fibonacci, count);
  for (int trial = 0; trial < 200; ++trial) {
    int count = 2 + below(&r, KM_SYMBOLS - 1);
    for (int s = 0; s < count; ++s)
      some[s] = s < 2 || below(&r, 2) ? 1U + (unsigned)exp(uniform(&r, 0.0, 12.0)) : 0;
    check_code(some, count);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(noise_comes_back), cmocka_unit_test(drawings_come_back_small),
                                     cmocka_unit_test(codes_are_whole)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
