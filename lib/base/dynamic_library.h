/* Libraries that are loaded when they are first needed, so that no other start of a tool pays for them. */
#ifndef KM_BASE_DYNAMIC_LIBRARY_H
#define KM_BASE_DYNAMIC_LIBRARY_H

#include <stdbool.h>

/* Functions that the files of a library hold. */
typedef struct km_library {
  const char *const *files; /* NULL behind the last */
  const char *const *names; /* of the functions; NULL behind the last */
  void *functions;          /* as many pointers to functions, in the order of the names */
  bool loaded;
} km_library;

/* Loads the functions, unless they are, whichever thread asks. NULL, or why they can't be had. Never unloaded. */
const char *km_library_load(km_library *library);

#endif
