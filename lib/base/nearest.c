/* Finds the names that are most like one that isn't there. */
#include "base/nearest.h"

#include <stdint.h>
#include <string.h>

enum { LONGEST = 64, OFFERED = 3 };

static size_t edits(const char *a, size_t n, const char *b, size_t k) {
  size_t row[LONGEST + 1];
  for (size_t j = 0; j <= k; ++j)
    row[j] = j;
  for (size_t i = 1; i <= n; ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= k; ++j) {
      size_t change = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      size_t gap = (row[j] < row[j - 1] ? row[j] : row[j - 1]) + 1;
      row[j] = change < gap ? change : gap;
    }
  }
  return row[k];
}

size_t km_name_distance(const char *wanted, const char *name) {
  if (strcmp(wanted, name) == 0)
    return 0;
  if (*wanted && *name && (strstr(name, wanted) || strstr(wanted, name)))
    return 1;
  return edits(wanted, strnlen(wanted, LONGEST), name, strnlen(name, LONGEST));
}

void km_nearest_names(const char *wanted, const char *const *names, size_t count, km_text *out) {
  size_t best[OFFERED], far[OFFERED], kept = 0;
  for (size_t i = 0; i < count; ++i) {
    size_t distance = km_name_distance(wanted, names[i]), at = kept;
    for (; at > 0 && far[at - 1] > distance; --at)
      if (at < OFFERED) {
        best[at] = best[at - 1];
        far[at] = far[at - 1];
      }
    if (at >= OFFERED)
      continue;
    best[at] = i;
    far[at] = distance;
    kept += kept < OFFERED;
  }
  for (size_t i = 0; i < kept; ++i)
    km_text_format(out, "%s\"%s\"", i == 0 ? "" : i + 1 == kept ? " or " : ", ", names[best[i]]);
}
