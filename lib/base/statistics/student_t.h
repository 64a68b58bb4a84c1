/* How well the mean of a few numbers is known. Private to the library. */
#ifndef KM_BASE_STATISTICS_STUDENT_T_H
#define KM_BASE_STATISTICS_STUDENT_T_H

/* Quantile 0.975 of Student's distribution with so many degrees of freedom (at least 1): half the width of the interval of 95 %
 * confidence of a mean, in its standard errors (Student, The probable error of a mean, Biometrika 6, 1908). */
double km_student(double freedoms);

#endif
