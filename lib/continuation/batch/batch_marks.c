/* Saving and restoring of the lanes' positions, and the history of moves of the degree-10 predictor. */
#include "continuation/batch/batch_arrays.h"

#include <string.h>

/* Shifts the moves of one lane: the latest, stored last, becomes the first. */
static void shift_moves(km_batch *l, int i) {
  for (int k = 0; k < l->sub->columns; ++k) {
    double latest = l->past[KM_CURVE_MOVES - 1][k].of[i];
    for (int j = KM_CURVE_MOVES - 1; j > 0; --j)
      l->past[j][k].of[i] = l->past[j - 1][k].of[i];
    l->past[0][k].of[i] = latest;
  }
}

/* Reverses the shift of a lane that took no step while the arrays were exchanged. */
static void unshift_moves(km_batch *l, int i) {
  for (int k = 0; k < l->sub->columns; ++k) {
    double rotated = l->past[0][k].of[i];
    for (int j = 0; j < KM_CURVE_MOVES - 1; ++j)
      l->past[j][k].of[i] = l->past[j + 1][k].of[i];
    l->past[KM_CURVE_MOVES - 1][k].of[i] = rotated;
  }
}

/* Rotates the moves of the lanes that took the step by one place: the new move, which the step wrote over the oldest
 * one in the last array, becomes the first. */
void km_batch_rotate_history(km_batch *l, unsigned took) {
  unsigned others = l->active & ~took;
  if (__builtin_popcount(took) <= __builtin_popcount(others)) {
    for (unsigned left = took; left; left &= left - 1)
      shift_moves(l, __builtin_ctz(left));
    return;
  }
  /* Most lanes took the step: the arrays are exchanged and the other lanes are shifted back. */
  km_batch_number *latest = l->past[KM_CURVE_MOVES - 1];
  memmove(l->past + 1, l->past, (KM_CURVE_MOVES - 1) * sizeof *l->past);
  l->past[0] = latest;
  for (unsigned left = others; left; left &= left - 1)
    unshift_moves(l, __builtin_ctz(left));
}

void km_batch_save(km_batch *l) {
  l->saved_current = l->current;
  memcpy(l->saved_past, l->past, sizeof l->past);
  memcpy(l->saved, l->q, l->position_count * sizeof *l->q);
}

void km_batch_restore(km_batch *l) {
  l->current = l->saved_current;
  memcpy(l->past, l->saved_past, sizeof l->past);
  memcpy(l->q, l->saved, l->position_count * sizeof *l->q);
}

void km_batch_restore_lane(km_batch *l, int i) {
  km_batch_number *current = (km_batch_number *)&l->current;
  const km_batch_number *saved = (const km_batch_number *)&l->saved_current;
  for (size_t k = 0; k < sizeof l->current / sizeof *current; ++k)
    current[k].of[i] = saved[k].of[i];
  for (size_t k = 0; k < l->position_count; ++k)
    l->q[k].of[i] = l->saved[k].of[i];
  for (int j = 0; j < KM_CURVE_MOVES; ++j)
    for (int k = 0; k < l->sub->columns; ++k)
      l->past[j][k].of[i] = l->saved[l->saved_past[j] - l->q + k].of[i];
}
