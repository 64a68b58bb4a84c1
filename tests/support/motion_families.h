/* Random families about motion and about what makes one: each call makes one case from a seed and checks it against a
 * truth of its own. False, with a line on stderr that says why, where the library disagrees. */
#ifndef KM_TESTS_MOTION_FAMILIES_H
#define KM_TESTS_MOTION_FAMILIES_H

#include <stdbool.h>
#include <stdint.h>

/* Inertias of rank 0 to 3 in any units, after unit conversion too, are accepted; one with a negative principal moment
 * is refused. */
bool family_inertia(uint64_t seed);

/* Sweeps of mechanisms with random limits whose own pose may be outside them: every row is within them, and the whole
 * range is delivered just where a fine trace says that it can be. */
bool family_limits(uint64_t seed);

/* Sweeps of random planar linkages with 5 to 44 rows: every joint has as many dead points as a fine trace of its
 * rate shows. */
bool family_dead_points(uint64_t seed);

/* Driven sweeps with several freedoms left: however the way is cut they end at one pose, to 1e-4, which is that of a
 * fine midpoint rule on least-norm rates by LAPACKE's SVD. */
bool family_least_path(uint64_t seed);

/* Finite mobility: paradoxical linkages with one freedom; a four-bar's coupler point in a straight slot with contact
 * of order 1 to 5 (rigid); bars with concurrent lines (infinitesimally mobile); flat parallelograms. */
bool family_moving(uint64_t seed);
bool family_contact(uint64_t seed);
bool family_shaky(uint64_t seed);
bool family_change_point(uint64_t seed);

/* Branches: curves s^m = c t^k (touching branches, cusps, isolated points); equal four-bars with tied cranks;
 * parallelograms with stretched chains; flat parallelograms beside nearly stretched bars; loops drawn straight or
 * folded; platforms on mirror-image legs. An undecided answer agrees and is counted apart. */
bool family_powers(uint64_t seed);
bool family_twins(uint64_t seed);
bool family_stretched(uint64_t seed);
bool family_change_beside_toggle(uint64_t seed);
bool family_straight_start(uint64_t seed);
bool family_mirrored_legs(uint64_t seed);
/* True if the answer of the last of these calls was undecided; the next call is false. */
bool family_is_undecided(void);

/* Overconstrained linkages rounded to 3 to 9 digits, near singular poses too: the tolerance that a refusal names gives
 * the mobility that it promises. Exact linkages with links of 1e-6 and 10 are accepted. */
bool family_rounded(uint64_t seed);
bool family_short_link(uint64_t seed);

/* Nearly singular loops: mirror images, other orders and senses of the joints, other frames get the same flag for a
 * doubtful rank, and the same mobility where it isn't doubtful. */
bool family_rank_flags(uint64_t seed);
/* Pivots of a nearly folded four-bar and of its mirror images, written in several ways, and how many are doubtful. */
typedef struct pivot_range {
  double least, most;
  int doubtful, count;
} pivot_range;
pivot_range mirrored_pivots(uint64_t seed, double height);

#endif
