/* Laws of static balance, at any closed pose, under random loads. */
#ifndef KM_TESTS_BALANCE_H
#define KM_TESTS_BALANCE_H

#include "support/support.h"

void law_equilibrium(fixture *f, randomness *r);  /* force and moment of every body add up to nothing */
void law_transmitted(fixture *f, randomness *r);  /* a joint's wrench has its actuator's force along its motion */
void law_least_norm(fixture *f, randomness *r);   /* D⁻¹ f̄ lies in the range of Z */
void law_virtual_work(fixture *f, randomness *r); /* no power in any free motion */
void law_reactions(fixture *f, randomness *r);    /* reactions and what is indeterminate, by LAPACKE on all equations */

#endif
