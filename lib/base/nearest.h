/* Which known names are nearest to one that isn't known. */
#ifndef KM_BASE_NEAREST_H
#define KM_BASE_NEAREST_H

#include <stddef.h>

/* Edit distance in bytes; SIZE_MAX where a text has more than 60. */
size_t km_text_distance(const char *a, const char *b);

enum { KM_NEAREST = 4 };
/* The few nearest names to `wanted` among those that are offered; start from {.wanted = …}. Names are borrowed. */
typedef struct km_nearest {
  const char *wanted;
  int count;
  const char *names[KM_NEAREST];
  size_t distance[KM_NEAREST];
} km_nearest;
void km_nearest_offer(km_nearest *nearest, const char *name);

enum { KM_NEAREST_TEXT = 256 };
/* `"a", "b"`: nearest first; "none" where none was offered. */
const char *km_nearest_text(const km_nearest *nearest, char out[KM_NEAREST_TEXT]);

#endif
