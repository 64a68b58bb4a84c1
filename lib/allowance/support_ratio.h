/* Greatest ratio of two support functions (docs/theory.md 14.9).
 *
 *   ρ = max h(a)/c(a) over a ≠ 0
 *   h(a) = Σ h_k |W_k a|  or  √Σ h_k² |W_k a|²      c(a) = Σ c_k |W_k a|
 *
 * A term is a ball of radius h_k, seen through rows W_k of a matrix: an error or a play whose direction is free. */
#ifndef KM_ALLOWANCE_SUPPORT_RATIO_H
#define KM_ALLOWANCE_SUPPORT_RATIO_H

#include "base/memory.h"

#include "base/number/tolerances.h"

#include <stdint.h>

typedef struct km_support_term {
  double size;     /* radius of the ball */
  int first, rows; /* rows of W, 1 to 3 */
  int owner;       /* joint to which it belongs */
} km_support_term;

/* Two lists of terms over one matrix. */
typedef struct km_support_terms {
  int rows, dimension;
  const double *W; /* [rows × dimension], row-major */
  double *length;  /* [rows] of each row */
  km_support_term *error, *play;
  int error_count, play_count;
} km_support_terms;

/* Σ size |W_k a|; with `squared` √Σ size² |W_k a|². `owner` below 0: all terms, else those of one joint. */
double km_support(const km_support_terms *terms, const km_support_term *list, int count, const double *a, bool squared,
                  int owner);

/* Search for ρ at configurations that follow each other. */
typedef struct km_ratio_search {
  int dimension, most; /* most: number of local maxima that are followed */
  int count;
  double *track; /* [most × dimension] the local maxima at the last configuration, the largest first */
  uint64_t draw; /* state of the sequence of starts */
} km_ratio_search;

/* Prepares a search with at most `most` followed maxima. False without memory. */
bool km_ratio_search_create(int dimension, int most, km_arena *arena, km_ratio_search *out);
/* Returns ρ of errors over play at the next configuration: the largest of the local maxima that ascents find from the
 * followed ones and from random starts, many at the first configuration, few at the others. search->track[0 …] is its
 * self-stress. counts[owner]: joints whose play counts, NULL: all. Infinite if c vanishes in a direction in which h
 * doesn't; NaN without memory. O(starts · steps · rows · dimension²), about 15 steps. */
double km_ratio_search_next(km_ratio_search *search, const km_support_terms *terms, bool squared, const bool *counts);

#endif
