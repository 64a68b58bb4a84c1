/* Tangents without passive freedoms (docs/theory.md 6.6). */
#ifndef KM_LOCAL_PASSIVE_TANGENTS_H
#define KM_LOCAL_PASSIVE_TANGENTS_H

#include "kmech/mobility.h"
#include "local/tangent_cone.h"

/* Removes passive freedoms that are finite from the basis of the tangents. They move independently of all others, so a
 * motion is finite with them if it is finite without them. The remaining basis is orthogonal to them. Before random
 * tangents are used. directions[freedom × columns] (may be NULL): removed tangents, scaled, of unit length. Returns
 * their number; 0 also when out of memory, by the arena's flag. O(freedom² · columns · groups) and following each
 * tangent. */
int km_passive_tangents_remove(km_tangents *tangents, const km_passive_freedoms *passive, double *directions);

#endif
