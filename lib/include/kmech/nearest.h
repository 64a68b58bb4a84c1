/* Which known names are nearest to one that isn't known: for messages that suggest them. */
#ifndef KMECH_NEAREST_H
#define KMECH_NEAREST_H

#include "kmech/api.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
  KM_NEAREST = 4 /* how many names are kept */
};
/* The few nearest names to `wanted` among those that are offered; start from {.wanted = …}. Names are borrowed. */
typedef struct km_nearest {
  const char *wanted; /* the name that isn't known */
  int count;
  const char *names[KM_NEAREST]; /* [count] nearest first */
  size_t distance[KM_NEAREST];   /* [count] edits from `wanted` */
} km_nearest;

/* By edit distance in bytes. O(bytes²). */
KM_API void km_nearest_offer(km_nearest *nearest, const char *name);

enum {
  KM_NEAREST_TEXT = 256 /* bytes of the text, the NUL included */
};
/* `"a", "b"`: nearest first; "none" where none was offered. Returns `out`. */
KM_API const char *km_nearest_text(const km_nearest *nearest, char out[KM_NEAREST_TEXT]);

#ifdef __cplusplus
}
#endif
#endif
