/* Libraries that are loaded at first use, so that other commands don't pay for their start. */
#ifndef KM_BASE_DYNAMIC_LIBRARY_H
#define KM_BASE_DYNAMIC_LIBRARY_H

#include <stdbool.h>

/* Functions of a library, and the files that may hold it. */
typedef struct km_library {
  const char *const *files; /* NULL after the last */
  const char *const *names; /* names of the functions; NULL after the last */
  void *functions;          /* pointers to the functions, in the order of the names */
  bool loaded;
} km_library;

/* Loads the functions once, thread-safe. Returns NULL, or the reason of the failure. The library is never unloaded. */
const char *km_library_load(km_library *library);

#endif
