/* The formats of pictures. */
#ifndef KMECH_PICTURE_FORMAT_H
#define KMECH_PICTURE_FORMAT_H

/* Of one input every format gives the same bytes on every machine: no date, no random id. */
typedef enum km_picture_format { KM_PICTURE_SVG, KM_PICTURE_PDF, KM_PICTURE_PNG } km_picture_format;

#endif
