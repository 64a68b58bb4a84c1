/* Calls for memory that fail one by one, in tests that are linked with --wrap=calloc,--wrap=realloc: the linker then
 * sends the library's calls through failing.c. */
#ifndef KM_TESTS_FAILING_H
#define KM_TESTS_FAILING_H

#include <stdbool.h>

/* From now on the n-th call finds no memory; 0: every call finds some. */
void failing_arm(long n);
/* How many there were since then. */
long failing_calls(void);
/* Counts a call; true: it is the one that fails. */
bool failing_next(void);

#endif
