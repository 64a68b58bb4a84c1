/* Null space of [J | −ξ]: path-control and pose-control columns (docs/theory.md 12.3), and minimum-norm solutions. */
#ifndef KM_ARM_PATH_CONTROL_H
#define KM_ARM_PATH_CONTROL_H

#include "arm/arm.h"

/* Relative pivot tolerance per column, and the path entry below which the path is impossible (singular
 * configuration). */
#define KM_ARM_PIVOT        1e-9
#define KM_PATH_ENTRY_LEAST 1e-9

/* Factors [J | −xi], xi[rows] the unit twist of the path, by the kernel of seven joints or by complete pivoting, and
 * finds the null space of J. Columns of joints marked in `fixed` (may be NULL) count as 0. Requires km_arm_update.
 * O(rows² n), no allocation. */
void km_control_factor(const km_arm *arm, km_arm_space *space, const double *xi, const bool *fixed);

/* Factors by complete pivoting for every arm; sets the space's partition. */
void km_control_pivot(const km_arm *arm, km_arm_space *space, const double *xi, const bool *fixed);

/* Computes path[n + 1] = c₁ = (q′, 1)/√(1 + |q′|²), q′ = J⁺ξ, and self[freedom × n], the pose-control columns
 * without their last entries 0. They are the closest ones to guide[freedom × n] (NULL: none). Returns the path entry
 * z; below KM_PATH_ENTRY_LEAST the path is impossible here. Requires km_control_factor. */
double km_control_columns(const km_arm *arm, const km_arm_space *space, const double *guide, double *path,
                          double *self);

/* Solves J x = rhs[rows] (in the range of J) for the x[n] with the least |moved + x|: moved + x is then orthogonal
 * to the null space. moved NULL: the minimum-norm x. Requires km_control_factor. */
void km_control_solve(const km_arm *arm, km_arm_space *space, const double *rhs, const double *moved, const bool *fixed,
                      double *x);

/* Subtracts the projection of x[n] on the null space. */
void km_control_project_out(const km_arm *arm, const km_arm_space *space, double *x);

#endif
