/* The left null vectors of a substructure, and the names of its redundant constraints. Private to analysis/. */
#ifndef KM_ANALYSIS_LEFT_NULL_H
#define KM_ANALYSIS_LEFT_NULL_H

#include "kinematics/state.h"
#include "kmech/redundancy.h"

/* Where a joint lies in a loop. */
typedef struct km_loop_place {
  int loop;   /* its place in the substructure */
  int member; /* into the topology's members */
} km_loop_place;

/* The whole Jacobian J of a substructure: the six rows of each loop about a point of its own, lengths over the
 * substructure's size, then the couplings. */
typedef struct km_left_space {
  const km_mechanism *m;
  km_state *s;
  int index, rows;
  const km_substructure *sub;
  double tolerance;
  int *first_place; /* [joint + 1] into `place`: the loops of each joint */
  km_loop_place *place;
  km_vec3 *about;     /* [loop] by its place in the substructure */
  signed char *helps; /* [4 · joint] what remedies.c has found out about swaps of a joint: 0 nothing yet */
} km_left_space;

/* An orthonormal basis of {w: wᵀJ = 0}: one wrench (f; τ) a loop and a force a coupling. What a loop has by itself is
 * kept as its six entries: long chains of loops have little else. */
typedef struct km_left_null {
  int *first;    /* [loop + 1] into `local`, by the loop's place in the substructure */
  double *local; /* [6 a vector] */
  double *whole; /* [rows a vector] of several loops together; 0 along all local ones */
  int local_count, whole_count;
} km_left_null;

/* False when out of memory. */
bool km_left_space_make(const km_mechanism *mechanism, km_state *state, int substructure, km_arena *arena,
                        km_left_space *out);
/* At the state's pose, whose partition and body poses must be up to date. False when out of memory. */
bool km_left_null_find(const km_left_space *space, km_arena *arena, km_left_null *out);
static inline int km_left_null_count(const km_left_null *null) {
  return null->local_count + null->whole_count;
}

/* Swaps of the loop's joints that would end a redundancy with the wrench w of the loop at `place` in the substructure,
 * by test. `null` are all left null vectors; `work` has room for 2 · whole_count. */
void km_remedies_find(const km_left_space *space, const km_left_null *null, int place, const double w[6], double *work,
                      km_redundancy *item);

#endif
