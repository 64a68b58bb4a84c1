/* Memory as the library allocates it: all of its allocation goes through here, so that it can be observed and failed. */
#ifndef KMECH_MEMORY_H
#define KMECH_MEMORY_H

#include "kmech/api.h"

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Zeroed; NULL when out of memory. O(bytes). */
KM_API void *km_alloc(size_t count, size_t size);
/* Another size for a block (NULL: none yet); what is new isn't zeroed. NULL when out of memory: the block stays. */
KM_API void *km_resize(void *block, size_t count, size_t size);
/* Frees a block of km_alloc, km_resize or km_reserve. NULL is legal. */
KM_API void km_free(void *block);

/* Zeroed room for `count` of a type. */
#define KM_NEW(type, count) ((type *)km_alloc((count), sizeof(type)))

/* Memory that lives and dies together. Start from {0}, allocate everything, then ask once whether it failed. */
typedef struct km_arena {
  struct km_arena_block *block; /* of the library */
  bool failed;                  /* an allocation has failed; nothing resets it */
} km_arena;

/* Zeroed, aligned to 64 bytes. NULL when out of memory; `failed` then stays set. */
KM_API void *km_arena_alloc(km_arena *arena, size_t count, size_t size);
/* A copy of a text; NULL gives NULL. */
KM_API char *km_arena_string(km_arena *arena, const char *text);
KM_API void km_arena_free(km_arena *arena);

/* The same in an arena. */
#define KM_ARENA_NEW(arena, type, count) ((type *)km_arena_alloc((arena), (count), sizeof(type)))

/* Grows `*data`, which km_free frees, and its `*capacity` to hold at least `need` elements; false when out of memory (data unchanged). */
KM_API bool km_reserve(void **data, size_t *capacity, size_t need, size_t size);

#ifdef __cplusplus
}
#endif
#endif
