/* Names that are like one that isn't there: what a message offers instead. */
#ifndef KM_BASE_NEAREST_H
#define KM_BASE_NEAREST_H

#include "base/text.h"

/* How far `wanted` is from `name`: the letters to change, insert or leave out; 1 where the one holds the other.
 * Names are compared by their first 64 bytes. */
size_t km_name_distance(const char *wanted, const char *name);

/* Appends the nearest names, at most three, nearest first: "a", "b" or "c". Of equally near ones the first come
 * first. O(count · length²). */
void km_nearest_names(const char *wanted, const char *const *names, size_t count, km_text *out);

#endif
