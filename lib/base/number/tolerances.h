/* Relative sizes below which a computed number is rounding. ε = 2.2e-16 is the rounding of one operation. */
#ifndef KM_BASE_NUMBER_TOLERANCES_H
#define KM_BASE_NUMBER_TOLERANCES_H

/* Rounding of a sum of products: 50 ε. */
static const double km_sum_rounding = 1e-14;
/* Rounding of the solution of a system with a condition number of 1e3, the largest that good pivots leave: loops are
 * closed to it, and a residual below it is 0. */
static const double km_solved_rounding = 1e-12;
/* Numbers that follow from a closed configuration by another such solution are 0 below this part of the others.
 * Configurations and steps closer than this, in radians or sizes, are equal. */
static const double km_relative_zero = 1e-9;
/* Square root of km_solved_rounding: accuracy of a number whose effect on a residual or on a maximum is of second
 * order, such as a body's pose at a singular configuration, in radians or lengths over the substructure's size. */
static const double km_root_rounding = 1e-6;
/* A number beyond its tolerance by this ratio is no effect of rounding or of rounded data. */
static const double km_significant_ratio = 100.0;

#endif
