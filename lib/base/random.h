/* Pseudo-random numbers, the same on every machine. */
#ifndef KM_BASE_RANDOM_H
#define KM_BASE_RANDOM_H

#include <stdint.h>

/* Uniform on [-1, 1): the next number of a linear congruential sequence (D. E. Knuth's MMIX). Start from *state = 1. */
static inline double km_uniform(uint64_t *state) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return (double)(*state >> 11) * 0x1p-52 - 1.0;
}

#endif
