/* Dead points of a coordinate: places where its entry in the unit direction of motion is 0. Private to analysis/. */
#ifndef KM_SWEEP_DEAD_POINTS_H
#define KM_SWEEP_DEAD_POINTS_H

#include "sweep/motion_directions.h"
#include "sweep/sweep.h"

/* An entry below this, which is known to about 1e-12, is 0. */
static const double km_dead = 1e-9;

/* The search for a root between a and b, where the function is fa and fb, of opposite sign: its value at `root` is wanted
 * while `open`, and then it is there. Regula falsi (Illinois). */
typedef struct km_root_search {
  double a, b, fa, fb, root, width;
  int round;
  bool open;
} km_root_search;
void km_root_search_begin(km_root_search *search, double a, double b, double fa, double fb);
/* The function is f at the root. */
void km_root_search_narrow(km_root_search *search, double f);

/* What follows moves the state, by the mover's probe: it has to be settled behind. */

/* The root between the places i and i + 1, where the entry has different signs. */
double km_dead_point_between(km_sweeper *sweeper, const km_directions *directions, int i, int coordinate);

/* An entry at three places, the newest last. */
typedef struct km_minimum_search {
  double s[3], f[3];
} km_minimum_search;

/* May the entry, which has one sign at the three places, be 0 between two of them? Where the parabola through them stays above
 * km_batch_minimum_ratio of the least one it hardly is. `lowest`: where the parabola is nearest to 0. */
bool km_minimum_search_is_zero(const km_minimum_search *dip, double *lowest);
/* Looks for the places, two where the entry changes its sign and back, or the one that it touches 0 in; returns how many there
 * are. */
int km_minimum_search_find(km_sweeper *sweeper, int coordinate, const km_minimum_search *dip, double lowest,
                           double roots[2]);

#endif
