/* Models of any number of four-bars, as text. */
#ifndef KM_TESTS_CHAINS_H
#define KM_TESTS_CHAINS_H

#include "base/text.h"

/* n crank-rockers in a row on the ground. */
void write_separate(km_text *out, int n);
/* n parallelograms, each rocker the next one's crank: one substructure. The last coupler hangs free: mobility 2. */
void write_chain(km_text *out, int n);

#endif
