/* Drawn mechanisms, from lists of their joints to text. */
#include "support/hinges.h"

#include <stdlib.h>

void hinges_add(hinges *h, const char *type, int parent, int child, km_vec3 at, km_vec3 axis) {
  if (h->count == h->room) {
    h->room = 2 * h->room + 64;
    h->all = realloc(h->all, (size_t)h->room * sizeof *h->all);
    if (!h->all)
      abort();
  }
  h->all[h->count++] = (hinge){type, {parent, child}, at, axis};
  int larger = parent > child ? parent : child;
  h->bodies = h->bodies > larger ? h->bodies : larger + 1;
}

void hinges_pin(hinges *h, int parent, int child, double x, double y) {
  hinges_add(h, "Rz", parent, child, (km_vec3){x, y, 0.0}, (km_vec3){0.0, 0.0, 1.0});
}

static void write_name(const hinges *h, km_text *out, int joint) {
  if (joint == h->count - 1)
    km_text_add(out, "\"last\"");
  else
    km_text_format(out, "\"j%d\"", joint);
}

/* The joint's frame on its bodies: its z is the axis. */
static void write_frame(const hinges *h, km_text *out, int joint, km_vec3 away) {
  km_vec3 p = km_vec3_add(h->all[joint].at, away), z = h->all[joint].axis;
  z = km_vec3_scale(1.0 / km_vec3_norm(z), z);
  km_vec3 x = km_vec3_perpendicular(z), y = km_vec3_cross(z, x);
  km_text_add(out, "{\"name\": ");
  write_name(h, out, joint);
  km_text_format(out,
                 ", \"T\": [%.17g, %.17g, %.17g], \"R\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g], [%.17g, "
                 "%.17g, %.17g]]}",
                 p.x, p.y, p.z, x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z);
}

/* Every body with the frames of its joints: `end` k is joint k / 2 on that joint's body k % 2. */
static void write_bodies(const hinges *h, km_text *out, double away) {
  int *first = malloc(((size_t)h->bodies + 2 * (size_t)h->count) * sizeof *first), *next = first + h->bodies;
  if (!first)
    abort();
  for (int b = 0; b < h->bodies; ++b)
    first[b] = -1;
  for (int end = 2 * h->count; end-- > 0;) {
    int body = h->all[end / 2].body[end % 2];
    next[end] = first[body];
    first[body] = end;
  }
  for (int b = 0; b < h->bodies; ++b) {
    km_text_format(out, "%s{\"name\": \"b%d\", \"frames\": [", b ? ", " : "", b);
    for (int end = first[b]; end >= 0; end = next[end]) {
      km_text_add(out, end == first[b] ? "" : ", ");
      write_frame(h, out, end / 2, (km_vec3){away, away, away});
    }
    km_text_add(out, "]}");
  }
  free(first);
}

void hinges_write(hinges *h, km_text *out, double away) {
  km_text_add(out, "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [");
  write_bodies(h, out, away);
  km_text_add(out,
              "], \"joints\": [{\"name\": \"ground\", \"type\": \"rigid\", \"body_frame_pairs\": [\"fixed\", \"b0\"]}");
  for (int j = 0; j < h->count; ++j) {
    km_text_add(out, ", {\"name\": ");
    write_name(h, out, j);
    km_text_format(out, ", \"type\": \"%s\", \"body_frame_pairs\": [", h->all[j].type);
    for (int side = 0; side < 2; ++side) {
      km_text_format(out, "%s[\"b%d\", ", side ? ", " : "", h->all[j].body[side]);
      write_name(h, out, j);
      km_text_add(out, "]");
    }
    km_text_add(out, "]}");
  }
  km_text_add(out, "]}]}");
  free(h->all);
  *h = (hinges){0};
}
