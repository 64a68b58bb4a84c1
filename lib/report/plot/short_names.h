/* Names of models short enough for a line's end, and still different. Private to report/. */
#ifndef KM_REPORT_PLOT_SHORT_NAMES_H
#define KM_REPORT_PLOT_SHORT_NAMES_H

#include "base/memory.h"

/* Shortens names: in a long name the words that all names share at the beginning or end become "…". out[count]; NULL
 * entries when out of memory. */
void km_short_names(const char *const *names, int count, km_arena *arena, const char **out);

/* km_short_names for names that are `stride` bytes apart. NULL when out of memory. */
const char **km_short_names_of(const char *const *first, size_t stride, int count, km_arena *arena);

#endif
