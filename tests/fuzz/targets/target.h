/* What the targets share. Each takes one input; libFuzzer makes them, or replay.c gives it files. */
#ifndef KM_TESTS_TARGET_H
#define KM_TESTS_TARGET_H

#include "judge.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
/* Damages an input as `seed` says, in room for `room` bytes; its new size. Those of texts are by mutations.c, which
 * knows tokens, half of the time; the others libFuzzer's own. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);

#endif
