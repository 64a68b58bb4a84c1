/* Location in a model file: `assemblies[0].joints[2].type`. A linked chain on the stack, converted to text only for
 * a report. */
#ifndef KM_EXCHANGE_JSON_JSON_LOCATION_H
#define KM_EXCHANGE_JSON_JSON_LOCATION_H

#include <stddef.h>

typedef struct km_place {
  const struct km_place *parent;
  const char *key; /* NULL: an item of a list */
  size_t index;
} km_place;

enum { KM_PLACE_TEXT = 256 };

/* A place too long for the buffer is cut at its end. Returns `out`. */
const char *km_place_text(const km_place *place, char out[KM_PLACE_TEXT]);

#endif
