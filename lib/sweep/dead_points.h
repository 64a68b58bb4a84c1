/* Dead points of a coordinate: zeros of its entry z_j in the unit direction of motion (theory 10.3). Private to
 * sweep/. */
#ifndef KM_SWEEP_DEAD_POINTS_H
#define KM_SWEEP_DEAD_POINTS_H

#include "sweep/motion_directions.h"
#include "sweep/sweep.h"

/* Entries below this are 0; they are known to about 1e-12. */
static const double km_zero_entry = 1e-9;

/* Search for a root between a and b with opposite signs of fa and fb: while `open`, the function's value at `root` is
 * required; then `root` is the result. Illinois variant of regula falsi. */
typedef struct km_root_search {
  double a, b, fa, fb, root, width;
  int iteration;
  bool open;
} km_root_search;
void km_root_search_begin(km_root_search *search, double a, double b, double fa, double fb);
/* Updates the search with the function's value f at `root`. */
void km_root_search_update(km_root_search *search, double f);

/* The following functions move the state by the mover's probe; the caller restores it. */

/* Returns the root between samples i and i + 1 with different signs of the entry. */
double km_dead_point_between(km_sweeper *sweeper, const km_directions *directions, int i, int coordinate);

/* An entry at three samples, the newest last. */
typedef struct km_minimum_search {
  double s[3], f[3];
} km_minimum_search;

/* True if the entry, of one sign in all three samples, can be 0 between two of them: the minimum of the parabola
 * through them is below km_batch_minimum_ratio of the least. `lowest`: its position. */
bool km_minimum_search_may_reach_zero(const km_minimum_search *samples, double *lowest);
/* Finds the two sign changes or the touching root; returns the number of roots. */
int km_minimum_search_find(km_sweeper *sweeper, int coordinate, const km_minimum_search *samples, double lowest,
                           double roots[2]);

#endif
