/* Mobility of a pose. */
#ifndef KMECH_MOBILITY_H
#define KMECH_MOBILITY_H

#include "kmech/kinematics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Evidence of a substructure's rank. Pivots are relative to its Jacobian's largest entry. */
typedef struct km_substructure_mobility {
  int joints, loops, coordinates;   /* coordinates: free ones */
  int rank, mobility;               /* of its Jacobian; coordinates − rank */
  double last_pivot, first_dropped; /* 0 dropped: nothing was left */
  double tolerance;                 /* relative, below which a pivot counts as 0 */
} km_substructure_mobility;

/* Counts of freedoms at a pose, by formulas and by rank. */
typedef struct km_mobility {
  int kutzbach;          /* 6(n − 1 − j) + Σ f − couplings (270) */
  int kutzbach_extended; /* Σ f − Σ λ − couplings */
  int kutzbach_planar; /* 3(n − 1 − j) + Σ f − couplings (Grübler): the count of mechanisms that move in a plane */
  int mobility;        /* Σ (coordinates − rank) + coordinates outside loops and couplings (271) */
  int redundant_constraints; /* 6 · loops + couplings − rank */
  double residual;           /* of the worst loop, scaled (235) */
} km_mobility;

/* Searches pivots afresh at the state's pose, which must be closed, and computes every mobility number
 * m_j = Σ_k Z_jk² (278)-(279), Z the orthonormal basis of D·range(N). O(rows · columns · rank) a
 * substructure. KM_USAGE: a pointer is missing, or the state is another mechanism's; KM_MEMORY: the mobility isn't known, and all is found
 * anew by the next call. `*out` is then all 0 with a residual of NaN. */
KM_API km_status km_mobility_update(const km_mechanism *mechanism, km_state *state, km_mobility *out);

/* How many kinematic substructures there are. */
KM_API int km_substructure_count(const km_mechanism *mechanism);
/* Rank, mobility and pivots of one, as the last km_mobility_update found them. All 0 if there is no such substructure. */
KM_API void km_substructure_evidence(const km_mechanism *mechanism, const km_state *state, int substructure,
                                     km_substructure_mobility *out);
/* After km_mobility_update: number of a coordinate; 0 for held ones, 1 outside loops and couplings. */
KM_API double km_mobility_number(const km_state *state, int coordinate);

#ifdef __cplusplus
}
#endif
#endif
