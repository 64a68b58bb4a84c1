/* SplitMix64: deterministic pseudo-random numbers (G. Steele, D. Lea and C. Flood 2014). */
#ifndef KM_ARM_METHODS_SPLITMIX_H
#define KM_ARM_METHODS_SPLITMIX_H

#include <stdint.h>

typedef struct km_random {
  uint64_t state;
} km_random;

static inline double km_random_between(km_random *r, double low, double high) {
  uint64_t z = (r->state += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  z ^= z >> 31;
  return low + (high - low) * ((double)(z >> 11) * 0x1p-53);
}

#endif
