/* Checks of the library's answers by every fuzzing program. */
#ifndef KM_TESTS_JUDGE_H
#define KM_TESTS_JUDGE_H

#include "kmech/mechanism.h"

#include <stddef.h>
#include <stdint.h>

/* Ends the program with a message. */
_Noreturn void fuzz_fail(const char *what);

/* The bytes in memory of their own size, so that a byte read too far is seen; to be freed. Ends the program without
 * memory. */
char *fuzz_exact(const void *bytes, size_t size);
/* A status that a bad input may give, with words. */
void fuzz_refusal(km_status status, const km_error *error);
/* True if every joint is closed, by its motion between the frames of its two bodies, to the residual of the
 * assembly. Call after km_poses_compute. */
void fuzz_closed(const km_model *model, const km_mechanism *mechanism, km_state *state, double residual);
/* Reads a model and runs all analyses. Returns 0 refused, 1 read, 2 assembled. */
int fuzz_model(const void *bytes, size_t size, size_t choice);

#endif
