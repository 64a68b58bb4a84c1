/* Student's t distribution for confidence intervals of a mean. Private to the library. */
#ifndef KM_BASE_STATISTICS_STUDENT_T_H
#define KM_BASE_STATISTICS_STUDENT_T_H

/* Quantile 0.975 of Student's distribution with `degrees` ≥ 1 degrees of freedom: half the width of the 95 %
 * confidence interval of a mean, in standard errors (Student, The probable error of a mean, Biometrika 6, 1908). */
double km_student(double freedoms);

#endif
