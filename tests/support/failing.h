/* Calls for memory that fail one by one, in tests that are linked with --wrap=calloc,--wrap=realloc: the linker then
 * sends the library's calls through failing.c. */
#ifndef KM_TESTS_FAILING_H
#define KM_TESTS_FAILING_H

#include <stdbool.h>

/* The n-th allocation from now on fails; 0: none. */
void failing_arm(long n);
/* Number of allocations since then. */
long failing_calls(void);
/* Counts a call; true: it is the one that fails. */
bool failing_next(void);

#endif
