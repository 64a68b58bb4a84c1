/* Shows from lengths alone that a loop can't close. Private to kinematics/. */
#ifndef KM_KINEMATICS_POLYGON_INEQUALITY_H
#define KM_KINEMATICS_POLYGON_INEQUALITY_H

#include "topology/mechanism.h"

/* The longest link of a loop that closes in no configuration. */
typedef struct km_long_link {
  double excess;      /* its length less the sum of the other links' lengths, scaled */
  int coordinates[2]; /* of the joints at its ends */
} km_long_link;

/* Polygon inequality: a closed loop of links with constant lengths l_i needs max l_i <= sum of the others. Lengths are
 * constant where every joint of the loop only turns (hinges, universal and ball joints). True, and `out` is filled, if
 * the loop violates it; false proves nothing. O(joints of the loop). */
bool km_loop_violates_polygon(const km_mechanism *mechanism, int loop, km_long_link *out);

#endif
