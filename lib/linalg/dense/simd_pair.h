/* Pairs of doubles in SIMD registers, and the search for the largest entry of a matrix as a maximum of keys.
 *
 *   key = bits of |x|, the lowest ten replaced by the complement of the entry's position (slot, row)
 *
 * The maximum carries its position along and needs no branch. Two entries that agree to 2⁻⁴² are a tie, which the lower
 * position wins. Lanes are combined in the last maximum only, which does not depend on the order: the result is equal
 * for any vector width. */
#ifndef KM_LINALG_DENSE_SIMD_PAIR_H
#define KM_LINALG_DENSE_SIMD_PAIR_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

typedef double km_pair __attribute__((vector_size(16), may_alias));
typedef int64_t km_bits __attribute__((vector_size(16), may_alias));

enum { KM_SLOT_BITS = 6, KM_ROW_BITS = 4, KM_PLACE_BITS = KM_SLOT_BITS + KM_ROW_BITS };
#define KM_MAGNITUDE INT64_MAX
#define KM_KEY       (INT64_MAX >> KM_PLACE_BITS << KM_PLACE_BITS)
#define KM_NEAR_KEY  (INT64_MAX >> 49 << 49) /* exponent and three bits of the mantissa: see KM_NEAR_TIE */

/* Maximum in each lane, b if a is NaN; and logic on the bits. */
#ifdef __SSE2__
static inline km_pair km_pair_larger(km_pair a, km_pair b) {
  return (km_pair)_mm_max_pd((__m128d)a, (__m128d)b);
}
static inline km_pair km_pair_and(km_pair a, km_pair b) {
  return (km_pair)_mm_and_pd((__m128d)a, (__m128d)b);
}
static inline km_pair km_pair_or(km_pair a, km_pair b) {
  return (km_pair)_mm_or_pd((__m128d)a, (__m128d)b);
}
#else
static inline km_pair km_pair_larger(km_pair a, km_pair b) {
  return (km_pair){a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]};
}
static inline km_pair km_pair_and(km_pair a, km_pair b) {
  return (km_pair)((km_bits)a & (km_bits)b);
}
static inline km_pair km_pair_or(km_pair a, km_pair b) {
  return (km_pair)((km_bits)a | (km_bits)b);
}
#endif

static inline km_pair km_pair_load(const double *from) { /* unaligned */
  km_pair a;
  memcpy(&a, from, sizeof a);
  return a;
}

/* Decoding of a key: its validity and position. Keys of entries that are 0 or masked are invalid. */
static inline int64_t km_key_bits(km_pair best) {
  double key = best[0] > best[1] ? best[0] : best[1];
  int64_t bits;
  memcpy(&bits, &key, sizeof bits);
  return bits;
}
static inline bool km_key_is_valid(int64_t key) {
  return key >> KM_PLACE_BITS != 0;
}
static inline int km_key_place(int64_t key) {
  return (int)(~key & ((1 << KM_PLACE_BITS) - 1));
}
static inline int km_place_slot(int place) {
  return place >> KM_ROW_BITS;
}
static inline int km_place_row(int place) {
  return place & ((1 << KM_ROW_BITS) - 1);
}

/* Position bits of a key: for slot s (the next slot: minus KM_NEXT_SLOT), and for rows r, r + 1. */
static inline km_bits km_slot_bits(int slot) {
  int64_t s = (int64_t)(((1 << KM_SLOT_BITS) - 1 - slot) << KM_ROW_BITS);
  return (km_bits){s, s};
}
#define KM_NEXT_SLOT ((km_bits){1 << KM_ROW_BITS, 1 << KM_ROW_BITS})
static inline km_pair km_row_bits(int row) {
  int64_t last = (1 << KM_ROW_BITS) - 1;
  return (km_pair)(km_bits){last - row, last - row - 1};
}

/* True if all values are finite: then x − x is 0. */
static inline bool km_all_finite(const double *x, int count) {
  km_pair poison[2] = {{0.0, 0.0}, {0.0, 0.0}};
  int i = 0;
  for (; i + 4 <= count; i += 4)
    for (int k = 0; k < 2; ++k)
      poison[k] += km_pair_load(x + i + 2 * k) - km_pair_load(x + i + 2 * k);
  for (; i < count; ++i)
    poison[0] += (km_pair){x[i] - x[i], 0.0};
  poison[0] += poison[1];
  return poison[0][0] + poison[0][1] == 0.0;
}

/* aᵀ b in SIMD lanes: eight partial sums. */
static inline double km_pair_dot(const double *a, const double *b, int count) {
  km_pair sums[4] = {{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}};
  int i = 0;
  for (; i + 8 <= count; i += 8)
    for (int k = 0; k < 4; ++k)
      sums[k] += km_pair_load(a + i + 2 * k) * km_pair_load(b + i + 2 * k);
  for (; i < count; ++i)
    sums[0] += (km_pair){a[i] * b[i], 0.0};
  sums[0] += sums[1] + (sums[2] + sums[3]);
  return sums[0][0] + sums[0][1];
}

/* Largest |x| of all values that are not NaN; 0 for none. */
static inline double km_max_magnitude(const double *x, int count) {
  const int64_t magnitude = KM_MAGNITUDE;
  const km_pair mask = (km_pair)(km_bits){magnitude, magnitude};
  km_pair best[2] = {{0.0, 0.0}, {0.0, 0.0}};
  int i = 0;
  for (; i + 4 <= count; i += 4)
    for (int k = 0; k < 2; ++k)
      best[k] = km_pair_larger(km_pair_and(km_pair_load(x + i + 2 * k), mask), best[k]);
  for (; i < count; ++i)
    best[0] = km_pair_larger(km_pair_and((km_pair){x[i], 0.0}, mask), best[0]);
  best[0] = km_pair_larger(best[0], best[1]);
  return best[0][0] > best[0][1] ? best[0][0] : best[0][1];
}

#endif
