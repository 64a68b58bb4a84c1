/* Constant-rank tangents in coefficients of a basis (docs/theory.md 5.6). Private to local/. */
#ifndef KM_LOCAL_CONSTANT_RANK_BASIS_H
#define KM_LOCAL_CONSTANT_RANK_BASIS_H

#include "local/second_order_conditions.h"

/* Computes the constant-rank tangents U = { a : Q_i a = 0 for all i }, to 1e-6 of the largest entry of Q, as
 * orthonormal rows of V[freedom × freedom], and completes the rows to an orthonormal basis. `count`: number of
 * constant-rank tangents that is known near the motion, so the tolerance is widened until there are as many; else 0.
 * Returns their number; 0: none, all, or out of memory. O(conditions · freedom³). */
int km_constant_rank_basis(const km_second_order *conditions, int count, km_arena *arena, double **V);
/* True if some combination of the other tangents satisfies the conditions, so that it can belong to a finite motion.
 * O(conditions · freedom³). */
bool km_constant_rank_others_may_be_finite(const km_second_order *conditions, const double *V, int constant_rank_count,
                                           km_arena *arena);

#endif
