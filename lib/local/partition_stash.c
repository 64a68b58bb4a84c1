/* Stashes the current factorisation and restores it. */
#include "local/partition_stash.h"

/* Swaps the present and the stored partition. */
static void swap_partitions(km_state *s, int index) {
  km_partition *p = &s->partition[index], current = *p;
  *p = s->stashed[index].stored;
  s->stashed[index].stored = current;
  s->basis[index].count = 0; /* Z belongs to the partition that was replaced */
}

/* Continues with a copy of the pivots in a second partition. */
void km_partition_stash(km_state *s, int index) {
  const km_substructure *sub = &s->mechanism->substructures[index];
  const km_partition *p = &s->partition[index];
  km_stashed_partition *a = &s->stashed[index];
  if (!p->sparse || a->is_swapped)
    return;
  a->is_reserved =
      a->is_reserved || km_partition_reserve_like(&a->stored, p, sub->rows, sub->columns, s->basis[index].arena);
  if (!a->is_reserved)
    return;
  a->stored.locked = p->locked;
  km_partition_copy_pivots(&a->stored, p);
  a->is_swapped = !a->stored.failed;
  if (a->is_swapped)
    swap_partitions(s, index);
}

void km_partition_unstash(km_state *s, int index) {
  if (s->stashed[index].is_swapped)
    swap_partitions(s, index);
  s->stashed[index].is_swapped = false;
}
