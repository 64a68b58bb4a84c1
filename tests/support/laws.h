/* Laws that hold at every closed pose of every mechanism. */
#ifndef KM_TESTS_LAWS_H
#define KM_TESTS_LAWS_H

#include "support/support.h"

typedef void (*law)(fixture *f, randomness *r);

void law_jacobian(fixture *f, randomness *r);   /* J is the derivative of the loop error */
void law_slopes(fixture *f, randomness *r);     /* polar form of the velocity products */
void law_null_space(fixture *f, randomness *r); /* J N = 0 for all six rows of every loop */
void law_numbers(fixture *f, randomness *r);    /* numbers in [0, 1], their sum, and those of LAPACKE's SVD */
void law_forced(fixture *f, randomness *r);     /* a forced driver doesn't change the numbers, and has minimum-norm
                                                 * rates */
void law_twists(fixture *f, randomness *r);     /* body twists are derivatives of the poses */
/* Laws of moving bodies; returns the number of moving bodies. */
int judge_twists(fixture *f, randomness *r);

#endif
