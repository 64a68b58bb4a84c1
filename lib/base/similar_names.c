/* Suggestions for an unknown name, by edit distance. */
#include "base/similar_names.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

size_t km_text_distance(const char *a, const char *b) {
  enum { LONGEST = 60 };
  size_t n = strlen(a), k = strlen(b), row[LONGEST + 1];
  if (n > LONGEST || k > LONGEST)
    return SIZE_MAX;
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

static size_t smaller(size_t a, size_t b) {
  return a < b ? a : b;
}

/* Distance in halves of an edit. The nearest names differ in capitals only, then by one edit. A name that contains
 * the wanted one, or is contained in it, is near whatever the length of the rest, and nearer if the shorter name is
 * the known one. */
static size_t distance_to(const char *wanted, const char *name) {
  enum { HALF_HELD = 3, HELD = 5 };
  size_t edits = km_text_distance(wanted, name), n = strlen(wanted), k = strlen(name);
  if (strcasecmp(wanted, name) == 0)
    return 0;
  edits = edits < SIZE_MAX / 2 ? 2 * edits : edits;
  bool holds = n && k && (strstr(name, wanted) || strstr(wanted, name)),
       half = 2 * smaller(n, k) >= n + k - smaller(n, k);
  return holds ? smaller(edits, half ? HALF_HELD : HELD) : edits;
}

void km_nearest_add(km_nearest *nearest, const char *name) {
  if (!nearest || !nearest->wanted || !name)
    return;
  size_t distance = distance_to(nearest->wanted, name);
  for (int i = 0; i < nearest->count; ++i)
    if (strcmp(nearest->names[i], name) == 0)
      return;
  int at = nearest->count < KM_NEAREST ? nearest->count++ : KM_NEAREST;
  while (at > 0 && distance < nearest->distance[at - 1]) {
    if (at < KM_NEAREST) {
      nearest->names[at] = nearest->names[at - 1];
      nearest->distance[at] = nearest->distance[at - 1];
    }
    --at;
  }
  if (at == KM_NEAREST)
    return;
  nearest->names[at] = name;
  nearest->distance[at] = distance;
}

const char *km_nearest_text(const km_nearest *nearest, char out[KM_NEAREST_TEXT]) {
  if (!nearest || !out)
    return "";
  size_t used = 0;
  strcpy(out, nearest->count ? "" : "none");
  for (int i = 0; i < nearest->count; ++i) {
    int length = snprintf(out + used, KM_NEAREST_TEXT - used, "%s\"%.50s\"", i ? ", " : "", nearest->names[i]);
    used += length > 0 ? (size_t)length : 0;
  }
  return out;
}
