/* Names to numbers, each within a scope: what finds bodies, joints and frames in constant time. */
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
/* Sets the value of (scope, name), new or not; false when out of memory. */
bool km_names_set(km_names *names, int scope, const char *name, int value);
/* The value, or -1 if the name isn't there. */
int km_names_get(const km_names *names, int scope, const char *name);

#endif
