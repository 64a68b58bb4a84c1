/* Bytes that the library hands over: the contents of a file. */
#ifndef KMECH_BYTES_H
#define KMECH_BYTES_H

#include "kmech/api.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Ended by a NUL that `size` doesn't count. */
typedef struct km_bytes {
  char *data;  /* the caller's, freed by km_bytes_free */
  size_t size; /* without the closing NUL */
} km_bytes;
/* Frees what `bytes` holds, and empties it. */
KM_API void km_bytes_free(km_bytes *bytes);

#ifdef __cplusplus
}
#endif
#endif
