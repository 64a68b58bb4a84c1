/* Two partitions of one substructure that stand in for each other. */
#include "local/partition_stash.h"

static void exchange(km_state *s, int index) {
  km_partition *p = &s->partition[index], kept = *p;
  *p = s->aside[index].other;
  s->aside[index].other = kept;
  s->basis[index].count = 0; /* it was made from the one that goes */
}

void km_partition_stash(km_state *s, int index) {
  const km_substructure *sub = &s->mechanism->substructures[index];
  const km_partition *p = &s->partition[index];
  km_stashed_partition *a = &s->aside[index];
  if (!p->sparse || a->is_out)
    return;
  a->is_reserved =
      a->is_reserved || km_partition_reserve_like(&a->other, p, sub->rows, sub->columns, s->basis[index].arena);
  if (!a->is_reserved)
    return;
  a->other.locked = p->locked;
  km_partition_copy_pivots(&a->other, p);
  a->is_out = !a->other.failed;
  if (a->is_out)
    exchange(s, index);
}

void km_partition_unstash(km_state *s, int index) {
  if (s->aside[index].is_out)
    exchange(s, index);
  s->aside[index].is_out = false;
}
