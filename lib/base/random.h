/* Pseudo-random numbers, the same on every machine. */
#ifndef KM_BASE_RANDOM_H
#define KM_BASE_RANDOM_H

#include <stdint.h>

/* Uniform on [-1, 1): the next number of a linear congruential sequence (D. E. Knuth's MMIX). Start from *state = 1. */
static inline double km_uniform(uint64_t *state) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return (double)(*state >> 11) * 0x1p-52 - 1.0;
}

/* Uniform on [low, high): SplitMix64 (G. Steele, D. Lea and C. Flood 2014). Any *state starts a sequence. */
static inline double km_splitmix(uint64_t *state, double low, double high) {
  uint64_t z = *state += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  z ^= z >> 31;
  return low + (high - low) * ((double)(z >> 11) * 0x1p-53);
}

#endif
