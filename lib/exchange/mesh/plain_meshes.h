/* Plain files of the two commonest formats, OBJ and STL, read without assimp, whose start takes longer than they do.
 * Whatever isn't plain (other statements, polygons that aren't flat and convex, faults) is left to assimp, which
 * then also reports what is wrong. */
#ifndef KM_EXCHANGE_MESH_PLAIN_MESHES_H
#define KM_EXCHANGE_MESH_PLAIN_MESHES_H

#include "kmech/base.h"
#include "model/geometry/mesh.h"

#include <stdbool.h>

/* Triangles in the making: three corners each. Start from {0}. */
typedef struct km_soup {
  km_vec3 *corners;
  size_t count, room;
  bool failed;    /* memory ran out */
  bool too_large; /* there are more than KM_MESH_MAX_TRIANGLES */
} km_soup;

void km_soup_add(km_soup *soup, km_vec3 a, km_vec3 b, km_vec3 c);

/* State of reading a text. */
typedef struct km_event_search {
  const char *at;
} km_event_search;

/* Each reads the next item of the line; false if it is another item or missing. */
bool km_event_search_word(km_event_search *scan, const char *expected);
bool km_event_search_point(km_event_search *scan, km_vec3 *out); /* reads finite numbers */
/* Goes behind the line's end. False: there is more on the line. */
bool km_event_search_end_line(km_event_search *scan);
void km_event_search_skip_line(km_event_search *scan);
void km_event_search_skip_blanks(km_event_search *scan);

/* Each adds triangles. False: the bytes aren't plain, or memory ran out; some may be added then. O(bytes). */
bool km_obj_scan(km_event_search *scan, km_soup *soup);
bool km_stl_scan(km_event_search *scan, km_soup *soup);
bool km_stl_take(const km_text *bytes, km_soup *soup); /* a binary one */

/* Adds the triangles of a file with these bytes, in the format of its extension; false as above. */
bool km_plain_mesh_scan(const char *path, const km_text *bytes, km_soup *soup);

/* Reads a file whose name ends in .obj or .stl. KM_OK with `*out` NULL: its name doesn't, or it isn't plain. The
 * caller frees `*out`. KM_IO, KM_MEMORY. */
km_status km_plain_mesh_read(const char *path, km_mesh **out, km_error *error);

#endif
