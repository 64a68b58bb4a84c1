/* Second-order conditions of motions at a closed configuration (docs/theory.md 5.2). Private to local/.
 *
 *   Q_i(a, b)   = w_iᵀ D²e(Z a, Z b) = −½ w_iᵀ (γ(a + b) − γ(a) − γ(b))
 *   tangent cone: aᵀ Q_i a = 0 for all i,  |a| = 1
 *
 * Z: orthonormal basis of the null space of J, in the metric D; w_i: left null vectors of J; a: coefficients of a
 * tangent. */
#ifndef KM_LOCAL_SECOND_ORDER_CONDITIONS_H
#define KM_LOCAL_SECOND_ORDER_CONDITIONS_H

#include "kinematics/state.h"

/* Tolerance of a condition over the size of Q. A condition that is a square converges slowly to its zero; below this
 * the direction is tried. */
static const double km_condition_tolerance = 1e-5;

/* True if unit vectors with this cosine can be one tangent, in either sense. A direction that misses a square by the
 * tolerance lies √tolerance from its zero, so two of one tangent are at most twice that apart, and 1 − cos is half the
 * square of that. */
static inline bool km_is_same_tangent(double cosine) {
  return 1.0 - fabs(cosine) <= 2.0 * km_condition_tolerance;
}

/* Quadratic conditions on the null space: the direction D⁻¹ Z a of a unit vector a[freedom] satisfies condition i if aᵀ
 * Q_i a = 0. */
typedef struct km_second_order {
  int columns, freedom, conditions;
  int passive_count;       /* passive freedoms that were removed from Z; `freedom` does not include them */
  bool has_redundant_rows; /* some constraint is redundant, so that tangents need not belong to motions */
  bool is_built;           /* Q is computed */
  double tolerance;
  double *Z;         /* [freedom × columns] orthonormal basis of D range(N); NULL: not created */
  double *Q;         /* [conditions × freedom × freedom] symmetric */
  double *W;         /* [conditions × rows] left null vectors, if all conditions are kept */
  double size;       /* largest entry of Q: scale of the conditions */
  double noise;      /* bound of entries of Q that the misfit of the configuration can cause */
  bool has_definite; /* some Q_i is definite: no direction satisfies its condition */
} km_second_order;

/* Factors J at the state's closed configuration: number of tangents, rank tolerance, noise. No basis and no conditions
 * yet. False when out of memory. */
bool km_second_order_count_tangents(const km_mechanism *mechanism, km_state *state, int substructure,
                                    km_second_order *out);
/* Creates the basis Z, directly after km_second_order_count_tangents. False when out of memory. */
bool km_second_order_create_basis(const km_mechanism *mechanism, const km_state *state, int substructure,
                                  km_arena *arena, km_second_order *out);
/* Computes the conditions at the same configuration: `build_all` keeps one per left null vector, `build` at most as
 * many as are independent. Dense, O(rows² · columns), so only where first order leaves a choice. False when out of
 * memory. */
bool km_second_order_build_all(const km_mechanism *mechanism, km_state *state, int substructure, km_arena *arena,
                               km_second_order *out);
bool km_second_order_build(const km_mechanism *mechanism, km_state *state, int substructure, km_arena *arena,
                           km_second_order *out);
/* Defect of the rank, for deflation (docs/theory.md 5.6): changes[conditions × freedom] = w_iᵀ J z of the null vectors,
 * which is 0 where J has the rank of w and z. All conditions must be kept. False when out of memory. */
bool km_second_order_rank_defect(const km_mechanism *mechanism, const km_state *state, int substructure,
                                 const km_second_order *conditions, double *changes);

/* Restricts the conditions to the tangents spanned by orthonormal coefficients shares[count × freedom], V Q_i Vᵀ. False
 * when out of memory. O(conditions · freedom² · count). */
bool km_second_order_restrict(const km_second_order *conditions, const double *coefficients, int count, km_arena *arena,
                              km_second_order *out);

/* True if the conditions exceed what the misfit of the configuration can cause. */
static inline bool km_second_order_is_significant(const km_second_order *c) {
  return c->conditions > 0 && !(c->size < c->noise);
}

/* Tangent z = Z a = D q̇, z[columns], of the coefficients a[freedom]. */
void km_second_order_combine(const km_second_order *conditions, const double *a, double *z);

/* Finds a unit vector near `a` that satisfies all conditions, by damped Gauss-Newton on the sphere; false if there is
 * none. work[freedom² + 3 · freedom]. */
bool km_second_order_solve(const km_second_order *conditions, double *a, double *work);

/* Dimension bound of a motion along a tangent a that satisfies the conditions: freedom − rank { Q_i a }. Only entries
 * that are clearly above the tolerance count for the rank. */
int km_second_order_dimension(const km_second_order *conditions, const double *a);

#endif
