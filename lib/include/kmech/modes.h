/* Assembly modes: the different ways in which loops close for one value of the driver. */
#ifndef KMECH_MODES_H
#define KMECH_MODES_H

#include "kmech/kinematics.h"
#include "kmech/progress.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The modes that were found. */
typedef struct km_modes {
  int count;           /* different configurations; the first is the state's own */
  double *coordinates; /* [count × coordinate count] model's units */
  bool isolated;       /* each stands alone; else something still moves in some of them, which are samples */
} km_modes;

enum {
  KM_MOST_MODE_STARTS = 1000000 /* the most random starts */
};

/* Fixes `driver` where the state has it, starts the other coordinates of its substructure at random places (the
 * same for the same seed), closes the loops, and keeps what differs by more than 1e-6 (full turns of hinges don't
 * count). The state must be assembled and keeps its pose. KM_USAGE if the driver is held or in no loop; KM_MEMORY;
 * KM_CANCELLED. Free `*out` in any case. */
KM_API km_status km_modes_find(const km_mechanism *mechanism, const km_state *state, int driver, int starts,
                               unsigned long seed, km_progress progress, void *context, km_modes *out, km_error *error);
KM_API void km_modes_free(km_modes *modes);

#ifdef __cplusplus
}
#endif
#endif
