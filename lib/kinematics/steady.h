/* The tangents along which the loops' equations keep their rank. Private to kinematics/ and analysis/. */
#ifndef KM_KINEMATICS_STEADY_H
#define KM_KINEMATICS_STEADY_H

#include "kinematics/tangents.h"

/* Some mechanisms shake all along their motion: at every pose first order allows more than moves, such as platforms on parallel rods, four
 * or more. Their tangents u are those with wᵀ(∂J/∂q u) z = 0 for all null vectors w of Jᵀ and z of J, that is Q_i a = 0 in all
 * conditions: to first order the rank of J stays along them. Where the conditions have no solution beside these, all real motions go
 * along them: they are a linear space, though the conditions are squares, which single directions meet only to half of the digits.
 *
 * Leaves such tangents alone in the basis, and no conditions. Returns how many others are taken out; their directions, scaled and
 * of unit length, are then in directions[freedom × columns] (may be NULL). 0: there are none, the others may be part of motions too,
 * or (by the arena's flag) memory is out. O(conditions · freedom³). */
int km_tangents_keep_steady(km_tangents *tangents, double *directions);

#endif
