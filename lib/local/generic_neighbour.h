/* Neighbouring configuration on the motion, to separate persistent from incidental properties (docs/theory.md 5.8). */
#ifndef KM_LOCAL_GENERIC_NEIGHBOUR_H
#define KM_LOCAL_GENERIC_NEIGHBOUR_H

#include "kinematics/state.h"

/* Moves one substructure by a few hundredths along a combination of all its motions and closes it. Rank of its
 * partition and poses of its bodies belong to the configuration found. False if nothing moves or the loops do not
 * close. km_generic_neighbour_leave restores the saved configuration, also after false. saved[KM_SAVED_PER_COLUMN ·
 * columns], move[columns]. The state's null space must be up to date. */
bool km_generic_neighbour_enter(const km_mechanism *mechanism, km_state *state, int substructure, double *saved,
                                double *move);
void km_generic_neighbour_leave(const km_mechanism *mechanism, km_state *state, int substructure, const double *saved);

#endif
