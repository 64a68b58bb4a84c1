/* Reads plain files of meshes. */
#include "exchange/mesh/plain_meshes.h"

#include "base/memory.h"
#include "base/text.h"
#include "exchange/mesh/import/stream.h"
#include "kmech/base.h"

#include <math.h>
#include <string.h>
#include <strings.h>

void km_soup_add(km_soup *soup, km_vec3 a, km_vec3 b, km_vec3 c) {
  void *corners = soup->corners;
  soup->too_large = soup->too_large || soup->count + 3 > KM_MESH_MAX_CORNERS;
  if (soup->too_large)
    return;
  if (!km_reserve(&corners, &soup->room, soup->count + 3, sizeof a))
    soup->failed = true;
  soup->corners = corners;
  if (soup->failed)
    return;
  soup->corners[soup->count++] = a;
  soup->corners[soup->count++] = b;
  soup->corners[soup->count++] = c;
}

static bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

static bool is_end(char c) {
  return c == '\n' || c == '\0' || is_blank(c);
}

void km_event_search_skip_blanks(km_event_search *scan) {
  while (is_blank(*scan->at))
    ++scan->at;
}

bool km_event_search_word(km_event_search *scan, const char *expected) {
  size_t size = strlen(expected);
  km_event_search_skip_blanks(scan);
  if (strncmp(scan->at, expected, size) != 0 || !is_end(scan->at[size]))
    return false;
  scan->at += size;
  return true;
}

static bool read_number(km_event_search *scan, double *out) {
  char *end;
  km_event_search_skip_blanks(scan);
  if (!strchr("+-.0123456789", *scan->at) || is_end(*scan->at))
    return false;
  *out = km_number_read(scan->at, &end);
  bool sound = end > scan->at && is_end(*end) && isfinite(*out);
  scan->at = end;
  return sound;
}

bool km_event_search_point(km_event_search *scan, km_vec3 *out) {
  return read_number(scan, &out->x) && read_number(scan, &out->y) && read_number(scan, &out->z);
}

bool km_event_search_end_line(km_event_search *scan) {
  km_event_search_skip_blanks(scan);
  if (*scan->at != '\n' && *scan->at != '\0')
    return false;
  scan->at += *scan->at == '\n';
  return true;
}

void km_event_search_skip_line(km_event_search *scan) {
  scan->at += strcspn(scan->at, "\n");
  scan->at += *scan->at == '\n';
}

/* No NUL inside, no lines that end or go on in other ways than a line feed, with or without a carriage return. */
static bool is_plain_text(const km_text *bytes) {
  if (strlen(bytes->data) != bytes->size || strstr(bytes->data, "\\\n") || strstr(bytes->data, "\\\r"))
    return false;
  for (const char *c = strchr(bytes->data, '\r'); c; c = strchr(c + 1, '\r'))
    if (c[1] != '\n')
      return false;
  return true;
}

static bool scan_text(const km_text *bytes, bool (*read)(km_event_search *, km_soup *), km_soup *soup) {
  if (!is_plain_text(bytes))
    return false;
  km_event_search scan = {bytes->data};
  return read(&scan, soup) && soup->count > 0;
}

static km_mesh *mesh_of(const km_soup *soup) {
  km_mesh *mesh = km_mesh_create((int)soup->count, (int)(soup->count / 3));
  if (!mesh)
    return NULL;
  memcpy(mesh->vertices, soup->corners, soup->count * sizeof *soup->corners);
  for (int t = 0; t < mesh->triangle_count; ++t)
    for (int k = 0; k < 3; ++k)
      mesh->triangles[t].corner[k] = 3 * t + k;
  return mesh;
}

static bool ends_in(const char *path, const char *ending) {
  size_t size = strlen(path), tail = strlen(ending);
  return size > tail && strcasecmp(path + size - tail, ending) == 0;
}

bool km_plain_mesh_scan(const char *path, const km_text *bytes, km_soup *soup) {
  if (bytes->size == 0)
    return false;
  if (ends_in(path, ".obj"))
    return scan_text(bytes, km_obj_scan, soup);
  return km_stl_take(bytes, soup) || (!soup->failed && scan_text(bytes, km_stl_scan, soup));
}

km_status km_plain_mesh_read(const char *path, km_mesh **out, km_error *error) {
  km_text bytes = {0};
  km_soup soup = {0};
  *out = NULL;
  if (!ends_in(path, ".obj") && !ends_in(path, ".stl"))
    return KM_OK;
  km_status status = km_file_read(path, &bytes, error);
  bool plain = !status && km_plain_mesh_scan(path, &bytes, &soup);
  km_text_free(&bytes);
  if (!status && soup.too_large)
    status = km_fail(error, KM_IO, "%s: has too many faces; expected at most %d", path, KM_MESH_MAX_TRIANGLES);
  else if (plain && (*out = mesh_of(&soup)) == NULL)
    soup.failed = true;
  km_free(soup.corners);
  return soup.failed ? km_fail(error, KM_MEMORY, "%s: out of memory", path) : status;
}
