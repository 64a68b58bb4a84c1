/* Common code of the targets. Each takes one input, from libFuzzer or from a file by replay.c. */
#ifndef KM_TESTS_TARGET_H
#define KM_TESTS_TARGET_H

#include "judge.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
/* Damages an input by `seed` in a block of `room` bytes; returns its new size. Texts are damaged by mutations.c,
 * which knows tokens, half of the time, otherwise by libFuzzer. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);

#endif
