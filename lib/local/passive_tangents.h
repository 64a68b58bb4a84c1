/* Tangents without the idle freedoms among them. Private to analysis/. */
#ifndef KM_LOCAL_PASSIVE_TANGENTS_H
#define KM_LOCAL_PASSIVE_TANGENTS_H

#include "kmech/mobility.h"
#include "local/tangent_cone.h"

/* Takes the idle motions out of the tangents' basis, as far as they are real: whatever else moves, they move by themselves, so that a
 * motion is real with them where it is without. What is left stands at right angles to them. Before random tangents are asked for.
 * directions[freedom × columns] (may be NULL): theirs, scaled and of unit length. Returns how many are taken out; 0 too when out of
 * memory, by the arena's flag. O(freedom² · columns · groups) and following each. */
int km_passive_tangents_remove(km_tangents *tangents, const km_passive_freedoms *idle, double *directions);

#endif
