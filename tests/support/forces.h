/* Families of random mechanisms under forces: results against other equations. Each returns false, with the reason
 * on stderr, if an answer is wrong. */
#ifndef KM_TESTS_FORCES_H
#define KM_TESTS_FORCES_H

#include "support/support.h"

/* Number of cases of a kind: a family without such cases shows nothing. */
typedef struct family_count {
  int moves, locks, open;        /* friction */
  int zeros, poles, peaks, ends; /* sweeps */
} family_count;

/* Planar linkages with friction: efficiency or lock against a continuation on all equations of balance. */
bool family_friction(uint64_t seed, family_count *count);
/* Wedges on two guides against the closed form. */
bool family_wedge(uint64_t seed, family_count *count);
/* Planar linkages of one freedom, by driver or arc length, and of two: where actuators rest, peak and have no bound,
 * against Cramer's rule on all equations of balance. */
bool family_planar_forces(uint64_t seed, family_count *count);
bool family_two_freedoms(uint64_t seed, family_count *count);
/* Spherical and spatial linkages, some with idle spins: the same against displacements alone. */
bool family_spatial_forces(uint64_t seed, family_count *count);
/* Planar linkages: toggles and extremes of a leverage against displacements. */
bool family_leverage(uint64_t seed, family_count *count);

#endif
