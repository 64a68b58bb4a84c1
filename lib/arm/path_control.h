/* The null space of [J | −ξ]: path-control and pose-control columns (theory 6), and steps of least norm. */
#ifndef KM_ARM_PATH_CONTROL_H
#define KM_ARM_PATH_CONTROL_H

#include "arm/arm.h"

/* Relative size below which a pivot counts as 0, and below which a path entry means that there is no way on. */
#define KM_ARM_PIVOT        1e-9
#define KM_PATH_ENTRY_LEAST 1e-9

/* Factors the space's Jacobian, by the kernel of its size or by pivoting, with −xi[rows] as its path column; the null
 * space of J itself. `held` columns (may be NULL) count as 0. After km_arm_update. O(rows² n), no allocation. */
void km_control_factor(const km_arm *arm, km_arm_space *space, const double *xi, const bool *held);

/* The same by complete pivoting whatever the arm: leaves the space's partition. */
void km_control_pivot(const km_arm *arm, km_arm_space *space, const double *xi, const bool *held);

/* After km_control_factor: path[n + 1] = c₁ = (q′, 1)/√(1 + |q′|²), q′ the least rates that follow the path, and
 * self[freedom × n] the pose-control columns (without their last entries 0), following `guide` [freedom × n] without
 * turning (NULL: none). Returns the path entry z; below KM_PATH_ENTRY_LEAST the path is impossible here. */
double km_control_columns(const km_arm *arm, const km_arm_space *space, const double *guide, double *path,
                          double *self);

/* After km_control_factor: the x[n] with J x = rhs[rows] (in the range of J) that makes moved[n] + x the least, moved
 * being no part of the null space then; NULL: 0, the least x. */
void km_control_solve(const km_arm *arm, km_arm_space *space, const double *rhs, const double *moved, const bool *held,
                      double *x);

/* Takes the null space's part out of x[n]. */
void km_control_project_out(const km_arm *arm, const km_arm_space *space, double *x);

#endif
