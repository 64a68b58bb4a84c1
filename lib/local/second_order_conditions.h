/* The tangents of a substructure that first and second order allow. Private to kinematics/. */
#ifndef KM_LOCAL_SECOND_ORDER_CONDITIONS_H
#define KM_LOCAL_SECOND_ORDER_CONDITIONS_H

#include "kinematics/state.h"

/* A condition that is a square meets 0 only slowly, but so far, over the size of its kind, is well enough to be tried. */
static const double km_condition_tolerance = 1e-5;

/* May unit vectors with this cosine be one tangent, in one sense or the other? What nearly meets a square is √km_condition_tolerance from
 * where it is 0, so two of one tangent are twice that from each other: 1 − cos is half the square of it. */
static inline bool km_is_same_tangent(double cosine) {
  return 1.0 - fabs(cosine) <= 2.0 * km_condition_tolerance;
}

/* Quadratic conditions on the null space: for a unit vector a (freedom entries), direction D⁻¹Z a, condition i is
 * aᵀ Q_i a = 0, Q_i = Zᵀ w_iᵀ(∂J/∂q) Z, w_i the left null vectors of J. */
typedef struct km_second_order {
  int columns, freedom, conditions;
  int passive_count;       /* freedoms that were taken out of Z, and don't count in `freedom` */
  bool has_redundant_rows; /* some constraint is: then conditions may stand between a tangent and a motion */
  bool is_built;           /* Q is */
  double tolerance;
  double *Z;         /* [freedom × columns] D·range(N), orthonormal; NULL: not asked for */
  double *Q;         /* [conditions × freedom × freedom] symmetric */
  double *W;         /* [conditions × rows] the left null vectors, where all conditions are kept */
  double size;       /* largest entry of Q: what a condition is compared with */
  double noise;      /* what the pose's misfit may have made of 0: Q below it says nothing */
  bool has_definite; /* some Q_i is: then no direction meets its condition */
} km_second_order;

/* How many tangents the state's (closed) pose has, which stays; no basis of them and no conditions yet. False when out of
 * memory. */
bool km_second_order_count_tangents(const km_mechanism *mechanism, km_state *state, int substructure,
                                    km_second_order *out);
/* The basis, right after that. False when out of memory. */
bool km_second_order_create_basis(const km_mechanism *mechanism, const km_state *state, int substructure,
                                  km_arena *arena, km_second_order *out);
/* The conditions at the same pose, all of them, or no more than are independent. Dense: O(rows² · columns), so only where first order leaves
 * a choice. False when out of memory. */
bool km_second_order_build_all(const km_mechanism *mechanism, km_state *state, int substructure, km_arena *arena,
                               km_second_order *out);
bool km_second_order_build(const km_mechanism *mechanism, km_state *state, int substructure, km_arena *arena,
                           km_second_order *out);
/* What pivots that count as 0 leave of J: changes[conditions × freedom] = wᵢᵀ J z of the null vectors w and z, 0 where J has their rank.
 * For conditions that are all kept. False when out of memory. */
bool km_second_order_rank_defect(const km_mechanism *mechanism, const km_state *state, int substructure,
                                 const km_second_order *conditions, double *changes);

/* The conditions on those tangents alone that are spanned by orthonormal shares[count × freedom] of the basis. False when out of memory.
 * O(conditions · freedom² · count). */
bool km_second_order_restrict(const km_second_order *conditions, const double *shares, int count, km_arena *arena,
                              km_second_order *out);

/* Do the conditions say more than the pose's misfit may have made of 0? */
static inline bool km_second_order_is_significant(const km_second_order *c) {
  return c->conditions > 0 && !(c->size < c->noise);
}

/* Z a, into z[columns]: the tangent D q̇ of these shares a[freedom] of the basis. */
void km_second_order_combine(const km_second_order *conditions, const double *a, double *z);

/* Starting from the unit vector a, goes to a nearby one that meets all conditions (Gauss-Newton on the sphere);
 * false if there is none. work[freedom² + 3 · freedom]. */
bool km_second_order_solve(const km_second_order *conditions, double *a, double *work);

/* The most dimensions that a motion along such an a can have. Its tangents at the pose are a cone of as many, in which a lies and
 * all conditions are met: freedom less the rank of their derivatives at a, of which only what is plain counts. */
int km_second_order_dimension(const km_second_order *conditions, const double *a);

#endif
