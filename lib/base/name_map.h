/* Map from (scope, name) to a number, for bodies, joints and frames. O(1). */
#ifndef KM_BASE_NAME_MAP_H
#define KM_BASE_NAME_MAP_H

#include <stdbool.h>
#include <stddef.h>

typedef struct km_name_entry {
  const char *name; /* borrowed */
  int scope, value;
} km_name_entry;

typedef struct km_names {
  km_name_entry *entries;
  size_t capacity, count;
} km_names;

void km_names_free(km_names *names);
/* Sets the value of (scope, name). False when out of memory. */
bool km_names_set(km_names *names, int scope, const char *name, int value);
/* The value of (scope, name), or -1. */
int km_names_get(const km_names *names, int scope, const char *name);

#endif
