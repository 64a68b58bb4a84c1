/* Loop over the substructures of a mechanism. Private to the library. */
#ifndef KM_MOBILITY_SUBSTRUCTURE_LOOP_H
#define KM_MOBILITY_SUBSTRUCTURE_LOOP_H

#include "kinematics/state.h"
#include "kmech/base.h"

/* Analyses one substructure; the arena is freed afterwards. KM_MEMORY needs no text. */
typedef km_status (*km_substructure_visitor)(void *self, int substructure, km_arena *arena, km_error *error);

/* Visits every substructure; the progress callback is called before each. KM_CANCELLED; KM_MEMORY with "out of memory
 * for <what>". */
km_status km_each_substructure(const km_mechanism *mechanism, km_substructure_visitor visit, void *self,
                               km_progress progress, void *context, const char *what, km_error *error);
/* Checks the arguments of a public search, updates poses and ranks, and visits every substructure. */
km_status km_search_substructures(const km_mechanism *mechanism, km_state *state, km_substructure_visitor visit,
                                  void *self, km_progress progress, void *context, const char *what, km_error *error);

#endif
