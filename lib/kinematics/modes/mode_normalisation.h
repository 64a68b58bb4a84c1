/* Random starts and normal forms of assembly modes (docs/theory.md 4.13).
 *
 *   struts: length |q|, their own joints closed again;   hinges: within half a turn of the original value, or within
 *   limits */
#ifndef KM_KINEMATICS_MODE_NORMALISATION_H
#define KM_KINEMATICS_MODE_NORMALISATION_H

#include "kinematics/state.h"

/* A state with the substructure whose modes are searched; the state's locks are kept. */
typedef struct km_mode_workspace {
  const km_mechanism *m;
  km_state *s;              /* configuration that the functions change */
  const km_state *original; /* values to which full turns of hinges are counted */
  int substructure;
  uint64_t random;               /* state of the random numbers */
  bool failed;                   /* out of memory */
  double *saved, *before, *step; /* [3 · columns] twice, [columns] */
  bool *locked;                  /* [coordinate] locks of the state at km_mode_workspace_reserve */
} km_mode_workspace;

/* Reserves the arrays in the arena and notes the state's locks. False when out of memory. */
bool km_mode_workspace_reserve(km_mode_workspace *work, km_arena *arena);
/* Random start: hinges uniform in [−π, π], slides within the substructure's size around the present value; locked
 * coordinates stay. */
void km_mode_randomise(km_mode_workspace *work);
/* Closes the substructure's loops from the present start. */
bool km_mode_close(km_mode_workspace *work);
/* Normalises a configuration: strut lengths of at least 0, hinge angles nearest to the original ones or within limits.
 * False if a strut could not be reversed. */
bool km_mode_normalise(km_mode_workspace *work);

#endif
