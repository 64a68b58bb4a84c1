/* Equations in cosines and sines of one angle and of two. */
#ifndef KM_ARM_IK_TRIGONOMETRIC_EQUATIONS_H
#define KM_ARM_IK_TRIGONOMETRIC_EQUATIONS_H

enum { KM_PAIRS_MOST = 16 };

/* line[0] cos x + line[1] sin x + line[2] = 0: the angles x[2]; where none does, but nearly, the nearest. Their number;
 * 0 also where every angle does. */
int km_solve_line(const double line[3], double x[2]);

/* Two equations e[0] cos x + e[1] sin x + e[2] cos y + e[3] sin y + e[4] = 0: pairs (x, y), up to four and some that
 * nearly do. −1: they don't determine pairs. */
int km_solve_pair(double e[2][5], double (*pairs)[2]);

#endif
