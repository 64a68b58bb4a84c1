/* Mechanisms of any number of bodies as text, as a CAD program gives them: every joint is stated by its place and
 * axis in the drawing of the whole, and is at 0 there. */
#ifndef KM_TESTS_HINGES_H
#define KM_TESTS_HINGES_H

#include "base/text.h"
#include "spatial/vec3.h"

/* "Rz" turns about `axis`, the first body being the joint's parent. */
typedef struct hinge {
  const char *type;
  int body[2];
  km_vec3 at, axis;
} hinge;

/* Body 0 stands still. */
typedef struct hinges {
  hinge *all;
  int count, room, bodies;
} hinges;

/* Joins bodies, which are there from their first hinge on. */
void hinges_add(hinges *h, const char *type, int parent, int child, km_vec3 at, km_vec3 axis);
/* Rz about the z axis. */
void hinges_pin(hinges *h, int parent, int child, double x, double y);

/* Writes the model and frees the hinges. The bodies are b0, b1, …, the joints j0, j1, …, of which the last one is
 * called `last`. `away` is how far from the inertial origin the mechanism is, in each direction. */
void hinges_write(hinges *h, km_text *out, double away);

#endif
