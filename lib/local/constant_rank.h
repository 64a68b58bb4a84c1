/* Constant-rank tangents and permanently shaky mechanisms (docs/theory.md 5.6).
 *
 *   U = { a : Q_i a = 0 for all i },   that is wᵀ (∂J/∂q u) z = 0 for all left and right null vectors w, z
 *
 * Along U the rank of J is constant to first order. The instantaneous mobility of a permanently shaky mechanism exceeds
 * the finite one along a whole branch (e.g. a platform on four or more parallel rods); its motions are tangent to U. */
#ifndef KM_LOCAL_CONSTANT_RANK_H
#define KM_LOCAL_CONSTANT_RANK_H

#include "kinematics/loop_closing.h"

/* Motion of a permanently shaky mechanism: its constant-rank tangents at the present configuration. */
typedef struct km_constant_rank {
  bool is_active;        /* the mechanism is permanently shaky */
  int rank;              /* rank of J along the motion */
  double rank_tolerance; /* relative pivot threshold near the motion: 0.1 × last accepted pivot */
  int count;             /* number of constant-rank tangents */
  double *Z;             /* [count × columns] constant-rank tangents D q̇, orthonormal */
  int capacity;          /* number of tangents for which Z has memory */
} km_constant_rank;

/* Tests whether the mechanism is permanently shaky along the motions through the state's configuration, in which the
 * driver (a column, KM_NO_DRIVER: any) moves. If so, is_active is set and the constant-rank tangents are found. The
 * state keeps its configuration; its pivots are those of the driver. Tested for at most 48 freedoms and rows² · columns
 * < 1e7. False when out of memory. */
bool km_constant_rank_begin(km_constant_rank *motion, const km_mechanism *mechanism, km_state *state, int substructure,
                            int driver, km_arena *arena);
/* Updates the constant-rank tangents at the state's configuration. False if it is not on the motion, or out of
 * memory. */
bool km_constant_rank_update(km_constant_rank *motion, const km_mechanism *mechanism, km_state *state,
                             int substructure);
/* Closes the loops near the motion and finds the constant-rank tangents there; the driver is fixed. Closing leaves the
 * shaky directions undetermined to the square root of the error; deflation, Newton's method on wᵀ J z = 0, determines
 * them. False: no configuration of the motion is close. */
bool km_constant_rank_close(km_constant_rank *motion, const km_mechanism *mechanism, km_state *state, int substructure,
                            int driver, km_closure *evidence);
/* Projects D `along` onto the constant-rank tangents: t with |D t| = 1, or for a driver (`along` is not read) with
 * t_driver = 1. False: the projection is nearly 0. */
bool km_constant_rank_tangent(const km_constant_rank *motion, const km_mechanism *mechanism, int substructure,
                              int driver, const double *along, double *t);

#endif
