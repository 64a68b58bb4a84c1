/* STL, as a text and in its binary form. */
#include "exchange/mesh/plain_meshes.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

static bool expect_line(km_event_search *scan, const char *first, const char *second) {
  return km_event_search_word(scan, first) && (!second || km_event_search_word(scan, second)) &&
         km_event_search_end_line(scan);
}

/* Reads from after "facet" to after "endfacet". The normal follows from the corners. */
static bool read_facet(km_event_search *scan, km_soup *soup) {
  km_vec3 corners[3];
  km_event_search_skip_line(scan);
  if (!expect_line(scan, "outer", "loop"))
    return false;
  for (int k = 0; k < 3; ++k)
    if (!km_event_search_word(scan, "vertex") || !km_event_search_point(scan, &corners[k]) ||
        !km_event_search_end_line(scan))
      return false;
  km_soup_add(soup, corners[0], corners[1], corners[2]);
  return expect_line(scan, "endloop", NULL) && expect_line(scan, "endfacet", NULL) && !soup->failed;
}

bool km_stl_scan(km_event_search *scan, km_soup *soup) {
  bool inside = false, plain = true;
  while (plain && *scan->at) {
    if (km_event_search_end_line(scan))
      continue;
    bool begins = !inside && km_event_search_word(scan, "solid"),
         ends = inside && km_event_search_word(scan, "endsolid");
    if (begins || ends) {
      inside = begins;
      km_event_search_skip_line(scan); /* a name */
    } else {
      plain = inside && km_event_search_word(scan, "facet") && read_facet(scan, soup);
    }
  }
  return plain && !inside;
}

enum { HEADER = 80, FACET = 50, CORNERS_FROM = 12 };

/* Little-endian, as the processors are that this runs on. */
bool km_stl_take(const km_text *bytes, km_soup *soup) {
  uint32_t count = 0;
  const char *at = bytes->data + HEADER + sizeof count;
  if (bytes->size >= HEADER + sizeof count)
    memcpy(&count, bytes->data + HEADER, sizeof count);
  if (count == 0 || bytes->size != HEADER + sizeof count + (uint64_t)count * FACET)
    return false;
  for (uint32_t i = 0; i < count && !soup->failed; ++i, at += FACET) {
    float x[9];
    memcpy(x, at + CORNERS_FROM, sizeof x);
    for (int k = 0; k < 9; ++k)
      if (!isfinite(x[k])) {
        soup->count = 0;
        return false;
      }
    km_vec3 corners[3];
    for (int k = 0; k < 3; ++k)
      corners[k] = (km_vec3){(double)x[3 * k], (double)x[3 * k + 1], (double)x[3 * k + 2]};
    km_soup_add(soup, corners[0], corners[1], corners[2]);
  }
  return !soup->failed;
}
