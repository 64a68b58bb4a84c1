/* The places of drives side by side, as they are kept and come back to, and the moves that led there. */
#include "continuation/batch/batch_arrays.h"

#include <string.h>

/* The moves of one lane become older by one. */
static void grow_older(km_batch *l, int i) {
  for (int k = 0; k < l->sub->columns; ++k) {
    double latest = l->past[KM_CURVE_MOVES - 1][k].of[i];
    for (int j = KM_CURVE_MOVES - 1; j > 0; --j)
      l->past[j][k].of[i] = l->past[j - 1][k].of[i];
    l->past[0][k].of[i] = latest;
  }
}

/* And younger, where all have grown older and this one took no step. */
static void grow_younger(km_batch *l, int i) {
  for (int k = 0; k < l->sub->columns; ++k) {
    double oldest = l->past[0][k].of[i];
    for (int j = 0; j < KM_CURVE_MOVES - 1; ++j)
      l->past[j][k].of[i] = l->past[j + 1][k].of[i];
    l->past[KM_CURVE_MOVES - 1][k].of[i] = oldest;
  }
}

void km_batch_extend_history(km_batch *l, unsigned took) {
  unsigned others = l->aboard & ~took;
  if (__builtin_popcount(took) <= __builtin_popcount(others)) {
    for (unsigned left = took; left; left &= left - 1)
      grow_older(l, __builtin_ctz(left));
    return;
  }
  /* The arrays change their places in place of all their numbers. */
  km_batch_number *latest = l->past[KM_CURVE_MOVES - 1];
  memmove(l->past + 1, l->past, (KM_CURVE_MOVES - 1) * sizeof *l->past);
  l->past[0] = latest;
  for (unsigned left = others; left; left &= left - 1)
    grow_younger(l, __builtin_ctz(left));
}

void km_batch_save(km_batch *l) {
  l->kept_here = l->here;
  memcpy(l->kept_past, l->past, sizeof l->past);
  memcpy(l->kept, l->q, l->place_count * sizeof *l->q);
}

void km_batch_restore(km_batch *l) {
  l->here = l->kept_here;
  memcpy(l->past, l->kept_past, sizeof l->past);
  memcpy(l->q, l->kept, l->place_count * sizeof *l->q);
}

void km_batch_restore_lane(km_batch *l, int i) {
  km_batch_number *here = (km_batch_number *)&l->here;
  const km_batch_number *kept = (const km_batch_number *)&l->kept_here;
  for (size_t k = 0; k < sizeof l->here / sizeof *here; ++k)
    here[k].of[i] = kept[k].of[i];
  for (size_t k = 0; k < l->place_count; ++k)
    l->q[k].of[i] = l->kept[k].of[i];
  for (int j = 0; j < KM_CURVE_MOVES; ++j)
    for (int k = 0; k < l->sub->columns; ++k)
      l->past[j][k].of[i] = l->kept[l->kept_past[j] - l->q + k].of[i];
}
