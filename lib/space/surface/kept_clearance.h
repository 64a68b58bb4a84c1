/* A least clearance that the configurations of a map keep (docs/theory.md 4.19).
 *
 *   excess = d(q) − d_least,   d the distance of a pair of bodies;   row: ∂d/∂q over the size */
#ifndef KM_SPACE_KEPT_CLEARANCE_H
#define KM_SPACE_KEPT_CLEARANCE_H

#include "base/memory.h"
#include "kinematics/state.h"
#include "kmech/clearance.h"

typedef struct km_kept_clearance {
  const km_clearance *clearance; /* NULL: none is kept */
  double least;                  /* model's unit */
  km_pair_clearance *pairs;      /* [pair] of the last configuration */
  double *gradient;              /* [coordinate] workspace */
} km_kept_clearance;

/* Allocates the arrays; clearance and least are given. False when out of memory. */
bool km_kept_clearance_create(km_kept_clearance *kept, const km_mechanism *m, km_arena *arena);
/* Updates the pairs at the state's configuration, whose poses are computed too. */
void km_kept_clearance_update(km_kept_clearance *kept, const km_mechanism *m, km_state *s);
/* Number of pairs; 0: none is kept. */
int km_kept_clearance_count(const km_kept_clearance *kept);
/* Excess of a pair at the last update. */
double km_kept_clearance_excess(const km_kept_clearance *kept, int pair);
/* Least excess of all pairs but one (−1: of all) at the last update; infinite without pairs. */
double km_kept_clearance_least(const km_kept_clearance *kept, int except);

#endif
