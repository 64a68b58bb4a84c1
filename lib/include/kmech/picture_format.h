/* The formats of pictures. */
#ifndef KMECH_PICTURE_FORMAT_H
#define KMECH_PICTURE_FORMAT_H

/* Of one input every format gives the same bytes on every machine: no date, no random id. */
typedef enum km_picture_format {
  KM_PICTURE_SVG, /* text, for browsers and editors */
  KM_PICTURE_PDF, /* a page */
  KM_PICTURE_PNG  /* pixels, two for each point of 1/72 inch */
} km_picture_format;

#endif
