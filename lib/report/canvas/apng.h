/* Animated PNG: pictures of one size, one after the other, for ever. */
#ifndef KM_REPORT_CANVAS_APNG_H
#define KM_REPORT_CANVAS_APNG_H

#include "base/text.h"
#include "kmech/base.h"

typedef struct km_apng {
  km_text *out;           /* borrowed; bytes are appended */
  unsigned frames, added; /* number of pictures announced, and added */
  unsigned sequence;      /* sequence number of the next animation chunk */
  unsigned milliseconds;  /* each picture stays */
  unsigned char size[8];  /* width and height as the first picture has them */
} km_apng;

/* Appends the next of `frames` PNG pictures; behind the last one the file is whole. KM_INTERNAL: it is no PNG, or
 * not of the first one's size; KM_MEMORY. */
km_status km_apng_add(km_apng *apng, const km_text *png, km_error *error);

#endif
