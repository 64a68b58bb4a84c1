/* Which of the motions that first order allows are real. */
#ifndef KMECH_FINITE_MOBILITY_H
#define KMECH_FINITE_MOBILITY_H

#include "kmech/mobility.h"
#include "kmech/progress.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How real a motion is that first order allows. */
typedef enum km_motion_kind {
  KM_MOTION_REGULAR, /* every direction of the null space is one of a smooth family */
  KM_MOTION_BRANCH,  /* one of several motions that meet at the pose */
  KM_MOTION_SHAKY,   /* allowed to first order, or a few more: the structure shakes, but doesn't move */
  KM_MOTION_OPEN     /* the loops were closed for a part of the way, and what stopped them tells neither */
} km_motion_kind;

/* One direction of motion, and how far it was followed with the loops closed. */
typedef struct km_finite_motion {
  km_motion_kind kind;     /* how real it is */
  int substructure;        /* that moves */
  double *direction;       /* [coordinate] unit rates: radians, lengths over the characteristic length */
  double confirmed_length; /* of arc: how far the loops stayed closed; 0 for shaky ones */
} km_finite_motion;

enum {
  KM_MOST_MOTIONS = 64 /* how many are listed */
};

/* The real motions at a pose. */
typedef struct km_finite_mobility {
  int mobility;   /* dimension of the set of real motions through the pose; the least it can be where undecided */
  bool undecided; /* some direction was neither confirmed nor refuted */
  int motion_count;
  bool truncated;                            /* there are more motions than are listed, or may be */
  km_finite_motion motions[KM_MOST_MOTIONS]; /* [motion_count] */
  double *store;                             /* of the directions */
} km_finite_mobility;

/* The finite mobility at an assembled configuration (theory 5). A substructure without redundant constraints has its
 * instantaneous mobility. Else the tangents are tried: all of them, and where that fails those that satisfy the
 * second-order condition wᵀ(J̇ q̇) = 0 for every left null vector w of J; each is confirmed by following it by 0.3 rad
 * (or substructure sizes) of its fastest coordinate, ahead and back. Where the loops open as a power of the way that
 * tangent is refuted. Where none of several tangents is left although the second order allows some, closed
 * configurations are looked for all around (cusps, branches with one tangent); if there are none, the answer is
 * `undecided`, never 0. Of a substructure with more than 12 freedoms, or more than 240 equations and more than one
 * freedom, random directions are tried: two where all tangents are finite motions, which then shows by one that is
 * followed, and at a branch point up to 1200 / coordinates of them, at least two; of those only a bound of the mobility
 * comes, `undecided`. The state keeps its configuration. Free `*out` in any case. KM_MEMORY. O(a few dozen sparse
 * factorisations) for each direction. */
KM_API km_status km_finite_mobility_find(const km_mechanism *mechanism, km_state *state, km_progress progress,
                                         void *context, km_finite_mobility *out, km_error *error);
/* How many motions meet at the configuration: the product over the substructures of their branches, each branch of
 * several freedoms counted once; at most 1e6. */
KM_API int km_finite_mobility_branches(const km_finite_mobility *mobility);
KM_API void km_finite_mobility_free(km_finite_mobility *mobility);
/* "regular", "branch", "shaky", "open"; "". */
KM_API const char *km_motion_kind_name(km_motion_kind kind);

#ifdef __cplusplus
}
#endif
#endif
