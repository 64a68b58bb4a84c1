/* Clearance: the shortest distances between bodies, from their shapes and meshes (docs/theory.md 14.10).
 *
 *   d(A, B) = max over unit n of min over a in A, b in B of n · (b − a)
 *
 * for two convex parts: their distance, or minus the depth of their overlap, which is the smallest displacement that
 * separates them. Bodies have the least distance of their parts. Boxes, spheres, cylinders and capsules are exact; a
 * mesh is the convex hulls of its connected components. Lengths are in the model's unit. */
#ifndef KMECH_CLEARANCE_H
#define KMECH_CLEARANCE_H

#include "kmech/base.h"
#include "kmech/mechanism.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The pairs of bodies whose clearance is computed, with their geometry. Immutable; shared by threads. */
typedef struct km_clearance km_clearance;

/* Reason for which km_clearance_create leaves out a pair. */
typedef enum km_left_out {
  KM_LEFT_OUT_RIGID,   /* the bodies don't move relative to each other: rigid or held joints connect them */
  KM_LEFT_OUT_JOINED,  /* a joint connects them */
  KM_LEFT_OUT_OVERLAP, /* they touch or overlap at the reference configuration */
  KM_LEFT_OUT_REASONS  /* number of enumerators */
} km_left_out;
/* The reason in words: "rigid", "joined", "overlap"; "" if invalid. */
KM_API const char *km_left_out_word(km_left_out reason);

/* Two bodies, by their indices in the model. */
typedef struct km_body_pair {
  int body[2];        /* indices in the model */
  km_left_out reason; /* reason of a pair that is left out; else ignored */
} km_body_pair;

/* Clearance of a pair of bodies. */
typedef struct km_pair_clearance {
  double distance; /* length; < 0: depth of the overlap of the parts that overlap most */
  double error;    /* bound of the numerical error of `distance`; hulls of meshes: km_clearance_hull_error besides */
  double point[2]
              [3];  /* closest points of the two bodies, in the inertial frame. Parallel faces have many: one of them */
  double normal[3]; /* unit vector from the first body to the second: distance = normal · (point[1] − point[0]) */
} km_pair_clearance;

/* Reads the geometry of the bodies and chooses the pairs: the given ones, or with `pair_count` 0 all pairs of bodies
 * with geometry but those that are rigid with each other, joined by a joint, or overlap at the configuration of
 * `state`, whose poses are computed (km_poses_compute). The mechanism must outlive `*out`, which the caller frees.
 * KM_USAGE: a body has neither mesh nor shapes, a pair has one body twice, or no pair remains; KM_IO: a mesh can't be
 * found or read; KM_MEMORY. Cost: about triangles · log triangles of the meshes for the hulls, and for their error the
 * triangles of the mesh times those of the hull. */
KM_API km_status km_clearance_create(const km_mechanism *mechanism, const km_state *state, const km_body_pair *pairs,
                                     int pair_count, km_clearance **out, km_error *error);
KM_API void km_clearance_free(km_clearance *clearance);

/* Number of pairs, and a pair; bodies -1 for an index out of range. */
KM_API int km_clearance_pair_count(const km_clearance *clearance);
KM_API km_body_pair km_clearance_pair(const km_clearance *clearance, int index);
/* Names of the bodies of a pair, "arm/frame", as in the names of columns; "" for an index out of range. Borrowed. */
KM_API const char *km_clearance_pair_name(const km_clearance *clearance, int index);
/* Number of pairs that were left out, and such a pair; bodies -1 for an index out of range. */
KM_API int km_clearance_left_out_count(const km_clearance *clearance);
KM_API km_body_pair km_clearance_left_out(const km_clearance *clearance, int index);
/* Number of convex parts of a body; 0 of bodies in no pair, and for an index out of range. */
KM_API int km_clearance_part_count(const km_clearance *clearance, int body);
/* Largest distance of the body's hulls from its meshes, an upper bound: clearances of the body are too small by at most
 * that. 0 of plain shapes; NaN for an index out of range. */
KM_API double km_clearance_hull_error(const km_clearance *clearance, int body);

/* Computes the clearance of every pair, out[pair count], and the index of the least one, the first of equal ones, in
 * `*nearest` (may be NULL). After km_poses_compute. No allocation; the same bits for any order of configurations and
 * any number of threads. KM_USAGE. Cost: about a microsecond for each pair of parts whose bounding balls decide
 * nothing. */
KM_API km_status km_clearance_compute(const km_clearance *clearance, const km_state *state, km_pair_clearance *out,
                                      int *nearest, km_error *error);
/* Gradient of a pair's distance by the coordinates, gradient[coordinate count]: normal · (velocity of point[1] −
 * velocity of point[0]) per unit rate of each coordinate along the spanning tree, as km_frame_jacobian; length per
 * radian or length. The loops allow only rates in the null space of the Jacobian: the rate of the distance is
 * gradient · rates. `of` is the result of km_clearance_compute at this configuration. Where the closest points jump, as
 * between parallel faces, the distance has no derivative, and this is one of its one-sided ones. KM_USAGE.
 * O(coordinates). */
KM_API km_status km_clearance_gradient(const km_clearance *clearance, const km_state *state, int pair,
                                       const km_pair_clearance *of, double *gradient, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
