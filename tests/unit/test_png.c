/* PNG files of pixels, read again chunk by chunk with zlib: checksums, header, and every pixel. */
#include "report/canvas/png.h"
#include "support/support.h"

#include <string.h>
#include <zlib.h>

enum { WIDTH = 37, HEIGHT = 23 };

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

static void check_lines(const unsigned char *data, uint32_t size, const uint32_t *pixels) {
  unsigned char lines[HEIGHT * (3 * WIDTH + 1)];
  uLongf count = sizeof lines;
  assert_int_equal(uncompress(lines, &count, data, size), Z_OK);
  assert_int_equal(count, sizeof lines);
  const unsigned char *at = lines;
  for (int y = 0; y < HEIGHT; ++y) {
    assert_int_equal(*at++, 0);
    for (int x = 0; x < WIDTH; ++x, at += 3)
      assert_int_equal(at[0] << 16 | at[1] << 8 | at[2], pixels[y * WIDTH + x]);
  }
}

static void comes_back(void **state) {
  (void)state;
  randomness r = {3};
  uint32_t pixels[HEIGHT * WIDTH], size;
  for (int i = 0; i < HEIGHT * WIDTH; ++i)
    pixels[i] = (uint32_t)below(&r, 1 << 24);
  km_text file = {0};
  const km_pixels picture = {(const unsigned char *)pixels, WIDTH, HEIGHT, WIDTH * 4, 5669};
  assert_true(km_png_write(&picture, &file));
  assert_memory_equal(file.data, "\x89PNG\r\n\x1a\n", 8);
  size_t place = 8;
  const unsigned char *data = next(&file, &place, "IHDR", &size);
  assert_int_equal(size, 13);
  assert_int_equal(number_at(data), WIDTH);
  assert_int_equal(number_at(data + 4), HEIGHT);
  data = next(&file, &place, "pHYs", &size);
  assert_int_equal(number_at(data), 5669);
  data = next(&file, &place, "IDAT", &size);
  check_lines(data, size, pixels);
  next(&file, &place, "IEND", &size);
  assert_int_equal(size, 0);
  assert_int_equal(place, file.size);
  km_text_free(&file);
}

/* A written file has no fault; a byte that is changed, or an end that is cut off, is one at every place. */
static void faults_are_found(void **state) {
  (void)state;
  static const uint32_t pixels[6] = {1, 2, 3, 4, 5, 6};
  km_text file = {0};
  int width, height;
  const km_pixels picture = {(const unsigned char *)pixels, 3, 2, 12, 5669};
  assert_true(km_png_write(&picture, &file));
  assert_null(km_png_fault(&file, &width, &height));
  assert_int_equal(width, 3);
  assert_int_equal(height, 2);
  for (size_t i = 0; i < file.size; ++i) {
    const km_text cut = {.data = file.data, .size = i};
    assert_non_null(km_png_fault(&cut, &width, &height));
    file.data[i] ^= 1;
    assert_non_null(km_png_fault(&file, &width, &height));
    file.data[i] ^= 1;
  }
  assert_null(km_png_fault(&file, &width, &height));
  km_text_free(&file);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(comes_back), cmocka_unit_test(faults_are_found)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
