/* Assembly: closing one substructure from a poor start (docs/theory.md 4.3). */
#ifndef KM_KINEMATICS_ASSEMBLY_H
#define KM_KINEMATICS_ASSEMBLY_H

#include "kinematics/state.h"

/* Newton's method, else Levenberg-Marquardt and Newton's method again. *closed is true if the loops are closed. saved[3
 * · columns] is workspace. KM_MEMORY. */
km_status km_assemble_one(const km_mechanism *mechanism, km_state *state, int substructure, double *saved,
                          bool *closed);

/* Suggested closure tolerance for rounded data. */
typedef struct km_suggestion {
  double tolerance, misfit; /* misfit: √(eᵀe/6) of the worst loop at that tolerance, scaled */
  int mobility;             /* mobility of the substructure */
} km_suggestion;

/* Finds the smallest closure tolerance among 1, 2, 5 times powers of ten up to 2e-3 with which the substructure closes
 * from the model's start and has a mobility of at least `least_mobility`. False: none. O(20 · (compiling the model +
 * closing its loops)). */
bool km_assemble_suggest(const km_mechanism *mechanism, int substructure, int least_mobility, km_suggestion *out);

#endif
