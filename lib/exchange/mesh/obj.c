/* Plain OBJ: points and flat, convex polygons; names, normals and textures are passed over. */
#include "base/memory.h"
#include "exchange/mesh/plain_meshes.h"

#include <math.h>
#include <stdlib.h>

typedef struct obj {
  km_event_search *scan;
  km_soup *soup;
  km_vec3 *points, *polygon;
  size_t count, room, polygon_count, polygon_room;
} obj;

static bool append(obj *o, km_vec3 **list, size_t *count, size_t *room, km_vec3 p) {
  void *items = *list;
  if (!km_reserve(&items, room, *count + 1, sizeof p))
    o->soup->failed = true;
  *list = items;
  if (o->soup->failed)
    return false;
  (*list)[(*count)++] = p;
  return true;
}

static bool read_point(obj *o) {
  km_vec3 p;
  return km_event_search_point(o->scan, &p) && km_event_search_end_line(o->scan) &&
         append(o, &o->points, &o->count, &o->room, p);
}

/* "7", "7/1", "7//3", "-1/2/3": the first counts points, from the first one or back from the last. */
static bool read_corner(obj *o) {
  char *end;
  long index = strtol(o->scan->at, &end, 10), count = (long)o->count;
  if (end == o->scan->at || index == 0 || index > count || index < -count)
    return false;
  while (*end == '/' || *end == '-' || (*end >= '0' && *end <= '9'))
    ++end;
  o->scan->at = end;
  return append(o, &o->polygon, &o->polygon_count, &o->polygon_room, o->points[index > 0 ? index - 1 : count + index]);
}

static km_vec3 across(km_vec3 a, km_vec3 b, km_vec3 c) {
  return km_vec3_cross(km_vec3_sub(b, a), km_vec3_sub(c, a));
}

/* Every corner turns left about the normal, seen from its neighbours and from the first corner, and lies in one
 * plane. */
static bool is_flat_and_convex(const km_vec3 *p, size_t n) {
  const double flat = 1e-6, least = 1e-9;
  km_vec3 normal = {0, 0, 0};
  for (size_t i = 2; i < n; ++i)
    normal = km_vec3_add(normal, across(p[0], p[i - 1], p[i]));
  double area = km_vec3_norm(normal);
  if (!(area > 0.0))
    return false;
  for (size_t i = 0; i < n; ++i) {
    km_vec3 corner = across(p[i], p[(i + 1) % n], p[(i + 2) % n]);
    if (km_vec3_dot(corner, normal) <= least * area * area)
      return false;
    if (i > 0 && i + 1 < n && km_vec3_dot(across(p[0], p[i], p[i + 1]), normal) <= 0.0)
      return false;
    if (fabs(km_vec3_dot(km_vec3_sub(p[i], p[0]), normal)) > flat * area * sqrt(area))
      return false;
  }
  return true;
}

/* Points and lines bound nothing. */
static bool read_polygon(obj *o) {
  o->polygon_count = 0;
  while (!km_event_search_end_line(o->scan))
    if (!read_corner(o))
      return false;
  size_t n = o->polygon_count;
  if (n > 3 && !is_flat_and_convex(o->polygon, n))
    return false;
  for (size_t i = 2; i < n; ++i)
    km_soup_add(o->soup, o->polygon[0], o->polygon[i - 1], o->polygon[i]);
  return true;
}

static bool read_line(obj *o) {
  static const char *const passed[] = {"vn", "vt", "g", "o", "s", "l", "p", "usemtl", "mtllib"};
  if (km_event_search_end_line(o->scan))
    return true;
  if (km_event_search_word(o->scan, "v"))
    return read_point(o);
  if (km_event_search_word(o->scan, "f"))
    return read_polygon(o);
  bool known = *o->scan->at == '#';
  for (size_t i = 0; i < sizeof passed / sizeof *passed; ++i)
    known = known || km_event_search_word(o->scan, passed[i]);
  km_event_search_skip_line(o->scan);
  return known;
}

bool km_obj_scan(km_event_search *scan, km_soup *soup) {
  obj o = {.scan = scan, .soup = soup};
  bool plain = true;
  while (plain && *scan->at)
    plain = read_line(&o);
  km_free(o.points);
  km_free(o.polygon);
  return plain && !soup->failed;
}
