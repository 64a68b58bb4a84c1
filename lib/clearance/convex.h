/* Convex parts of bodies, and the signed distance of two of them (docs/theory.md 14.10).
 *
 *   A = core ⊕ ball:  core = convex hull of points ⊕ disc about an axis
 *   h_A(n) = max over A of n · x: support function
 *   d(A, B) = max over unit n of −h_A(n) − h_B(−n):  the distance of two parts, or minus the depth of their overlap
 *
 * n points from A to B. A ball only shifts the maximum, so that spheres and capsules are exact. */
#ifndef KM_CLEARANCE_CONVEX_H
#define KM_CLEARANCE_CONVEX_H

#include "spatial/pose.h"

/* A convex part in the frame of its body. Lengths in the model's unit. */
typedef struct km_convex {
  int count;             /* points of the core, at least 1 */
  const km_vec3 *points; /* [count] */
  double radius;         /* ball around the core: spheres and capsules; else 0 */
  double disc;           /* radius of the disc: cylinders; else 0 */
  km_vec3 axis;          /* unit normal of the disc */
  km_vec3 center;        /* centre and radius of a ball that contains the part */
  double reach;
} km_convex;

/* A point of the Minkowski difference of two cores, w = a − b. */
typedef struct km_difference_point {
  km_vec3 w, a, b;
} km_difference_point;

/* Two convex parts, B at `pose` in the frame of A. */
typedef struct km_convex_pair {
  const km_convex *part[2];
  km_pose pose;
} km_convex_pair;

/* Signed distance of two parts, in the frame of A. */
typedef struct km_convex_distance {
  double distance; /* < 0: depth of the overlap */
  double error;    /* bound of |distance − exact distance|: gap between the bounds of the method, and rounding */
  km_vec3 normal;  /* unit vector from A to B */
  km_vec3 a, b;    /* closest points, distance = normal · (b − a) */
} km_convex_distance;

/* Point of the part's core that is farthest in the direction d. */
km_vec3 km_convex_support(const km_convex *part, km_vec3 d);
/* Farthest point of the difference of the cores in the direction d: h(d) = d · w. */
km_difference_point km_difference_support(const km_convex_pair *pair, km_vec3 d);

/* Computes the signed distance of two parts. No allocation. Cost: about ten support points, each linear in the points;
 * of cylinders and overlaps some tens. */
km_convex_distance km_convex_distance_compute(const km_convex_pair *pair);

/* Depth of the overlap of two cores whose difference contains the origin: min over unit n of h(n). `scale` bounds the
 * coordinates of the difference. The result keeps its points where the difference has no volume. */
void km_convex_depth_compute(const km_convex_pair *pair, double scale, km_convex_distance *out);

#endif
