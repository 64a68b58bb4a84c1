/* Looking at one substructure after the other. Private to analysis/. */
#ifndef KM_MOBILITY_SUBSTRUCTURE_LOOP_H
#define KM_MOBILITY_SUBSTRUCTURE_LOOP_H

#include "kinematics/state.h"
#include "kmech/base.h"

/* Looks at one; what it allocates in the arena is freed behind it. KM_MEMORY needs no text. */
typedef km_status (*km_substructure_look)(void *self, int substructure, km_arena *arena, km_error *error);

/* Asks the progress callback before each. KM_CANCELLED; KM_MEMORY with "out of memory for <what>". */
km_status km_each_substructure(const km_mechanism *mechanism, km_substructure_look look, void *self,
                               km_progress progress, void *context, const char *what, km_error *error);

#endif
