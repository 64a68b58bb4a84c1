/* Stashes the current factorisation and restores it. */
#include "local/partition_stash.h"

/* Swaps the present and the stored partition. */
static void swap_partitions(km_state *s, int index) {
  km_factor_swap(s->factor[index], s->stashed[index].stored);
}

/* Continues with a copy of the pivots in a second partition. */
void km_factor_stash(km_state *s, int index) {
  km_stashed_factor *a = &s->stashed[index];
  if (!s->mechanism->substructures[index].pattern.start || a->is_swapped)
    return;
  if (!a->stored)
    a->stored = km_factor_create_like(s->factor[index], &s->arena);
  if (!a->stored)
    return;
  km_factor_copy_pivots(a->stored, s->factor[index]);
  a->is_swapped = !km_factor_has_failed(a->stored);
  if (a->is_swapped)
    swap_partitions(s, index);
}

void km_factor_unstash(km_state *s, int index) {
  if (s->stashed[index].is_swapped)
    swap_partitions(s, index);
  s->stashed[index].is_swapped = false;
}
