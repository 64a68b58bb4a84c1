/* Closing one substructure from any start. Private to kinematics/. */
#ifndef KM_KINEMATICS_ASSEMBLE_H
#define KM_KINEMATICS_ASSEMBLE_H

#include "kinematics/state.h"

/* Newton, else damped least squares and Newton again; true if the loops close. saved[3 · columns] is workspace. */
bool km_assemble_one(const km_mechanism *mechanism, km_state *state, int substructure, double *saved);

#endif
