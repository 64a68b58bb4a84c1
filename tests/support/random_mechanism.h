/* Random mechanisms: any topology, any joint types, any senses, perhaps gears, closed by construction. */
#ifndef KM_TESTS_RANDOM_MECHANISM_H
#define KM_TESTS_RANDOM_MECHANISM_H

#include "support/support.h"

/* The text of one; the caller frees it (km_free). */
char *random_mechanism(randomness *r, bool gears);

/* One at any pose that keeps its loops closed. */
fixture open_random_mechanism(randomness *r, bool gears);

#endif
