/* Assembly modes: the different ways in which loops close for one value of the driver. */
#ifndef KMECH_MODES_H
#define KMECH_MODES_H

#include "kmech/kinematics.h"
#include "kmech/progress.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The modes that were found, with the evidence of the search. */
typedef struct km_modes {
  int count;           /* different modes within the joint limits; the first is the state's own, wherever that is */
  double *coordinates; /* [count × coordinate count] model's units */
  bool isolated;       /* each stands alone; else something still moves in some of them, which are samples */
  int closed;          /* starting configurations that led to a mode, the state's own included */
  int once;            /* modes that just one of these led to: the more, the more are likely to be missing */
  int outside;         /* further modes, which lie outside the joint limits */
} km_modes;

enum {
  KM_MOST_MODE_STARTS = 1000000 /* the most random starts */
};

/* Fixes `driver` where the state has it (-1, for a structure: nothing, in the largest substructure), starts the other
 * coordinates of its substructure at random places (the same for the same seed), and closes the loops. Two
 * configurations are one mode if the places of the bodies are the same to 1e-6; the turn of a rod about the line
 * between its joints, the halves of struts, and the crosspiece of a universal joint don't count. Struts have lengths
 * of at least 0. The state must be assembled and keeps its configuration. No number of starts shows that all modes are
 * found. KM_USAGE if the driver is held or in no loop, or there is none and something moves; KM_MEMORY; KM_CANCELLED.
 * Free `*out` in any case. O(starts · (closing the loops + modes · bodies)). */
KM_API km_status km_modes_find(const km_mechanism *mechanism, const km_state *state, int driver, int starts,
                               unsigned long seed, km_progress progress, void *context, km_modes *out, km_error *error);
KM_API void km_modes_free(km_modes *modes);

#ifdef __cplusplus
}
#endif
#endif
