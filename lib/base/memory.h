/* Memory functions of the library beyond kmech/base.h: arrays that grow in an arena, recycled arenas. */
#ifndef KM_BASE_MEMORY_H
#define KM_BASE_MEMORY_H

#include "kmech/base.h"

/* Grows the array `*data` of the arena to at least `need` elements. Its contents are kept; the old block is freed
 * with the arena only. False when out of memory; the array is then unchanged. */
bool km_arena_grow(km_arena *arena, void **data, size_t *capacity, size_t need, size_t size);
/* Moves all blocks of `from`, which must not have failed, to `arena` and leaves `from` empty. */
void km_arena_merge(km_arena *arena, km_arena *from);
/* Recycled memory. Gives all blocks of `memory` (NULL: none) to an empty arena. */
km_arena km_arena_reuse(km_arena *memory);
/* Empties the arena and stores its blocks in the empty `memory`; frees them if `memory` is NULL. */
void km_arena_recycle(km_arena *arena, km_arena *memory);

#endif
