/* Closing one substructure from any start. Private to kinematics/. */
#ifndef KM_KINEMATICS_ASSEMBLY_H
#define KM_KINEMATICS_ASSEMBLY_H

#include "kinematics/state.h"

/* Newton, else damped least squares and Newton again; *closed if the loops close then. saved[3 · columns] is
 * workspace. KM_MEMORY. */
km_status km_assemble_one(const km_mechanism *mechanism, km_state *state, int substructure, double *saved,
                          bool *closed);

/* A closure tolerance for rounded data. */
typedef struct km_suggestion {
  double tolerance, misfit; /* misfit: rms of the worst loop that is then left, scaled */
  int mobility;             /* of the substructure */
} km_suggestion;

/* The closure tolerance, of the ladder 1, 2, 5 times powers of ten up to 2e-3, with which the substructure closes from
 * the file's start with at least `least_mobility`. False: none. O(20 · compiling the model and closing its loops). */
bool km_assemble_suggest(const km_mechanism *mechanism, int substructure, int least_mobility, km_suggestion *out);

#endif
