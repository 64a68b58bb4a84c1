/* All of the library's allocation goes through this file, so that it can be observed and failed. */
#ifndef KM_BASE_MEMORY_H
#define KM_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

void *km_alloc(size_t count, size_t size);               /* zeroed; NULL when out of memory */
void *km_resize(void *block, size_t count, size_t size); /* new space is not zeroed */
void km_free(void *block);

#define KM_NEW(type, count) ((type *)km_alloc((count), sizeof(type)))

/* Memory that lives and dies together. Allocate everything first, then ask once whether it failed. */
typedef struct km_arena {
  struct km_arena_block *block;
  bool failed;
} km_arena;

/* Zeroed, aligned to 64 bytes. NULL when out of memory; `failed` then stays set. */
void *km_arena_alloc(km_arena *arena, size_t count, size_t size);
char *km_arena_string(km_arena *arena, const char *text); /* NULL gives NULL */
void km_arena_free(km_arena *arena);

/* Grows `*data`, which lies in the arena, to hold at least `need` elements; what it held stays, the old space is lost
 * until the arena goes. False when out of memory (data unchanged). */
bool km_arena_grow(km_arena *arena, void **data, size_t *capacity, size_t need, size_t size);

#define KM_ARENA_NEW(arena, type, count) ((type *)km_arena_alloc((arena), (count), sizeof(type)))

/* Grows `*data` to hold at least `need` elements; false when out of memory (data unchanged). */
bool km_reserve(void **data, size_t *capacity, size_t need, size_t size);

#endif
