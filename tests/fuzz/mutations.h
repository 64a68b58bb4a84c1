/* Inputs of the fuzzing test. */
#ifndef KM_TESTS_MUTATIONS_H
#define KM_TESTS_MUTATIONS_H

#include <stddef.h>
#include <stdint.h>

enum { LONGEST = 1 << 18 };

typedef struct input {
  char *bytes;
  size_t size;
} input;

/* One of the files, damaged by the seed, in a block of LONGEST bytes that the caller frees. */
input mutation_make(uint64_t seed, const input *files, size_t count);

#endif
