/* A chain of parallelograms with all links on one line, where each goes on as such or crossed. */
#ifndef KM_TESTS_FOLDED_H
#define KM_TESTS_FOLDED_H

#include "support/support.h"

/* n of them, their cranks half as long as their couplers; the last coupler hangs free. 2^n branches meet. */
fixture folded_chain(int n);

#endif
