/* Memory inside of the library: kmech/base.h, and arrays that grow in an arena. */
#ifndef KM_BASE_MEMORY_H
#define KM_BASE_MEMORY_H

#include "kmech/base.h"

/* Grows `*data`, which lies in the arena, to hold at least `need` elements; what it held stays, the old space is lost
 * until the arena goes. False when out of memory (data unchanged). */
bool km_arena_grow(km_arena *arena, void **data, size_t *capacity, size_t need, size_t size);
/* What lives in `from`, which hasn't failed, lives on in `arena`; `from` is empty then. */
void km_arena_join(km_arena *arena, km_arena *from);
/* Memory that goes from one owner to the next. Takes it all, for an arena in which nothing lives yet; NULL: there is none. */
km_arena km_arena_take(km_arena *memory);
/* Nothing lives in the arena any more: its memory goes into `memory`, which is empty; NULL: it is freed. */
void km_arena_give(km_arena *arena, km_arena *memory);

#endif
