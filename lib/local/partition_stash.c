/* Two partitions of one substructure that stand in for each other. */
#include "local/partition_stash.h"

static void exchange(km_state *s, int index) {
  km_partition *p = &s->partition[index], kept = *p;
  *p = s->stashed[index].stored;
  s->stashed[index].stored = kept;
  s->basis[index].count = 0; /* it was made from the one that goes */
}

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
    exchange(s, index);
}

void km_partition_unstash(km_state *s, int index) {
  if (s->stashed[index].is_swapped)
    exchange(s, index);
  s->stashed[index].is_swapped = false;
}
