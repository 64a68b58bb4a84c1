/* Pixels as a PNG file, and the chunks that such files consist of. Private to report/. */
#ifndef KM_REPORT_CANVAS_PNG_H
#define KM_REPORT_CANVAS_PNG_H

#include "kmech/base.h"

#include <stdbool.h>
#include <stdint.h>

/* Cairo's RGB24: numbers 0x00RRGGBB, line by line. */
typedef struct km_pixels {
  const unsigned char *data;
  int width, height, stride; /* pixels; bytes from line to line */
  unsigned per_metre;        /* resolution */
} km_pixels;

/* Appends the file; false when out of memory, or where zlib isn't there. O(pixels). */
bool km_png_write(const km_pixels *pixels, km_text *out);

/* Sets width and height of a PNG file and returns NULL; otherwise returns its fault: the signature, a chunk that is cut
 * off, damaged or missing, or a side of more than KM_PNG_MOST pixels. O(bytes). */
enum { KM_PNG_MOST = 4096 };
const char *km_png_fault(const km_text *png, int *width, int *height);

/* Four bytes, the highest first. */
void km_png_put_number(unsigned char *at, uint32_t value);
/* Appends a chunk whose data come in two parts. */
void km_png_put_chunk(km_text *out, const char *type, const unsigned char *head, uint32_t head_size,
                      const unsigned char *data, uint32_t size);

#endif
