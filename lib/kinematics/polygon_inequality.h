/* Polygon inequality of a loop: a proof that it closes in no configuration (docs/theory.md 4.3). Private to
 * kinematics/. */
#ifndef KM_KINEMATICS_POLYGON_INEQUALITY_H
#define KM_KINEMATICS_POLYGON_INEQUALITY_H

#include "topology/mechanism.h"

/* Longest link of a loop that violates the polygon inequality. */
typedef struct km_long_link {
  double excess;      /* length of that link minus the sum of the other lengths, scaled */
  int coordinates[2]; /* coordinates of the joints at its ends */
} km_long_link;

/* Tests max l_i <= sum of the others for the constant link lengths l_i of a loop whose joints only rotate (hinges,
 * universal and ball joints). True, with `out` filled, if the loop violates it; false proves nothing. O(joints of the
 * loop). */
bool km_loop_violates_polygon(const km_mechanism *mechanism, int loop, km_long_link *out);

#endif
