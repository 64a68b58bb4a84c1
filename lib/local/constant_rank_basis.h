/* Steady tangents as shares of a basis. Private to kinematics/. */
#ifndef KM_LOCAL_CONSTANT_RANK_BASIS_H
#define KM_LOCAL_CONSTANT_RANK_BASIS_H

#include "local/second_order_conditions.h"

/* Into V[freedom × freedom] the steady tangents, as orthonormal shares of the basis: the common null space of all Q_i, to 1e-6 of their
 * largest entry; and behind them others at right angles. Near the motion, where it is known that `count` are steady, as many as are nearly
 * so; else `count` is 0. Returns how many are steady, 0: none, all, or memory is out. O(conditions · freedom³). */
int km_constant_rank_basis(const km_second_order *conditions, int count, km_arena *arena, double **V);
/* May some of the others together meet the conditions? Then they may be part of motions too. O(conditions · freedom³). */
bool km_constant_rank_others_may_be_finite(const km_second_order *conditions, const double *V, int steady,
                                           km_arena *arena);

#endif
