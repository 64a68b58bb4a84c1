/* A pose a short way along the motion, to tell what lasts from what is special about a pose. Private to analysis/. */
#ifndef KM_LOCAL_GENERIC_NEIGHBOUR_H
#define KM_LOCAL_GENERIC_NEIGHBOUR_H

#include "kinematics/state.h"

/* Moves one substructure by a few hundredths along all its motions and closes it; its partition's rank and body poses
 * are those of the pose found. False where nothing moves or the loops don't close there. Then or later, km_generic_neighbour_leave
 * brings the saved pose back. saved[KM_SAVED_PER_COLUMN · columns], move[columns]. The state's null space must be up to
 * date. */
bool km_generic_neighbour_enter(const km_mechanism *mechanism, km_state *state, int substructure, double *saved,
                                double *move);
void km_generic_neighbour_leave(const km_mechanism *mechanism, km_state *state, int substructure, const double *saved);

#endif
