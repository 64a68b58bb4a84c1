/* The tangents along which the loops' equations keep their rank. Private to kinematics/ and analysis/. */
#ifndef KM_LOCAL_CONSTANT_RANK_MOTION_H
#define KM_LOCAL_CONSTANT_RANK_MOTION_H

#include "kinematics/loop_closing.h"
#include "local/tangent_cone.h"

/* Some mechanisms shake all along their motion: at every pose first order allows more than moves, such as platforms on parallel rods, four
 * or more. Their tangents u are those with wᵀ(∂J/∂q u) z = 0 for all null vectors w of Jᵀ and z of J, that is Q_i a = 0 in all
 * conditions: to first order the rank of J stays along them. Where the conditions have no solution beside these, all real motions go
 * along them: they are a linear space, though the conditions are squares, which single directions meet only to half of the digits.
 *
 * Leaves such tangents alone in the basis, and no conditions. Returns how many others are taken out; their directions, scaled and
 * of unit length, are then in directions[freedom × columns] (may be NULL). 0: there are none, the others may be part of motions too,
 * or (by the arena's flag) memory is out. O(conditions · freedom³). */
int km_tangents_restrict_to_constant_rank(km_tangents *tangents, double *directions);

/* Are the conditions of so few rows and columns found in next to no time? They are dense. */
static inline bool km_constant_rank_is_small(const km_substructure *sub) {
  static const double most_work = 1e7;
  return (double)sub->rows * sub->rows * sub->columns < most_work;
}

/* A motion along which a mechanism shakes: its tangents at the present pose. */
typedef struct km_constant_rank {
  bool is_active;        /* the mechanism shakes all along */
  int rank;              /* of J all along */
  double rank_tolerance; /* what is 0 on the motion is less near it: a part of the last pivot */
  int count;             /* how many tangents are steady, */
  double *Z;             /* [count × columns] and they: D q̇, orthonormal */
  int capacity;          /* for tangents */
} km_constant_rank;

/* Does the mechanism shake all along the motions through the state's pose, and does the driver (a column, KM_NO_DRIVER: any) move in them?
 * Then steady tangents are found at the pose, which the state keeps; its pivots are the driver's. Small and middle-sized mechanisms alone
 * are looked at. False when out of memory. */
bool km_constant_rank_begin(km_constant_rank *steady, const km_mechanism *mechanism, km_state *state, int substructure,
                            int driver, km_arena *arena);
/* The steady tangents at the state's pose, which is on the motion. False: it isn't, or memory is out. */
bool km_constant_rank_update(km_constant_rank *steady, const km_mechanism *mechanism, km_state *state,
                             int substructure);
/* Closes the loops at a pose near the motion, and finds the steady tangents there; the driver stands. Closing alone leaves what shakes by the
 * root of the error; Newton's method on wᵀ J z = 0 takes it away. False: no pose of the motion is near by. */
bool km_constant_rank_close(km_constant_rank *steady, const km_mechanism *mechanism, km_state *state, int substructure,
                            int driver, km_closure *evidence);
/* D⁻¹ times the part of D `along` that is steady, of unit length |D t|; of a driver (`along` is then not read) its rate is 1. False: there is
 * hardly any. */
bool km_constant_rank_tangent(const km_constant_rank *steady, const km_mechanism *mechanism, int substructure,
                              int driver, const double *along, double *t);

#endif
