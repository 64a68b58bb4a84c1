/* A smooth path beside one of straight steps (docs/theory.md 4.21).
 *
 *   u(x)   splines of the drivers through some configurations of the path, the knots; q by steps along u with the
 *          drivers at u, each allowed as those of the path
 *   peak   L² max |d²u/ds²|,  s length along the curve, L the whole: acceleration of a motion over unit time
 *   knots  both ends; where the curve isn't allowed, the configuration farthest from it in that interval is a further
 *          one (D. Douglas, T. Peucker 1973); then further ones at the peak, and fewer, as long as the peak lessens */
#ifndef KM_SPACE_PATH_CURVE_H
#define KM_SPACE_PATH_CURVE_H

#include "space/path/path_points.h"
#include "space/path/path_trees.h"

/* Replaces the points by those of a smooth path. *is_smooth: false where none was allowed, and the points stay. False
 * when out of memory. O(knots · steps). */
bool km_path_curve_smooth(km_path_trees *trees, km_path_points *points, bool *is_smooth);

#endif
