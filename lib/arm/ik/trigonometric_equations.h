/* Equations in the cosines and sines of one angle and of two angles. */
#ifndef KM_ARM_IK_TRIGONOMETRIC_EQUATIONS_H
#define KM_ARM_IK_TRIGONOMETRIC_EQUATIONS_H

enum { KM_MAX_PAIRS = 16 };

/* Solves line[0] cos x + line[1] sin x + line[2] = 0 for x[2]. If the equation is missed by less than half its
 * amplitude, x is the closest angle. Returns the number of angles; 0 also if every angle is a solution. */
int km_solve_cos_sin(const double line[3], double x[2]);

/* Solves two equations e[0] cos x + e[1] sin x + e[2] cos y + e[3] sin y + e[4] = 0 for pairs (x, y): up to four,
 * and some approximate ones. −1: the pairs aren't isolated. */
int km_solve_cos_sin_pair(double e[2][5], double (*pairs)[2]);

#endif
