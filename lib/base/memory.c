/* Allocation and arenas. */
#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Size of an arena's first block, and the largest size of a block: many arenas are small. With KM_LONE_BLOCKS each
 * request has its own block, so that sanitizers detect an overrun and tests can fail each request. */
#ifdef KM_LONE_BLOCKS
enum { FIRST_BLOCK = 0, LARGEST_BLOCK = 0, ALIGNMENT = 64 };
#else
enum { FIRST_BLOCK = 1 << 11, LARGEST_BLOCK = 1 << 16, ALIGNMENT = 64 };
#endif

struct km_arena_block {
  struct km_arena_block *previous;
  size_t used, size;
};

void *km_alloc(size_t count, size_t size) {
  return calloc(count ? count : 1, size);
}

void *km_resize(void *block, size_t count, size_t size) {
  if (size != 0 && count > SIZE_MAX / size)
    return NULL;
  size_t bytes = count * size;
  return realloc(block, bytes ? bytes : 1);
}

void km_free(void *block) {
  free(block);
}

static char *block_start(struct km_arena_block *block) {
  char *start = (char *)(block + 1);
  return start + (ALIGNMENT - (uintptr_t)start % ALIGNMENT) % ALIGNMENT;
}

static bool new_block(km_arena *arena, size_t size) {
  size_t usual = arena->block ? 2 * arena->block->size : FIRST_BLOCK;
  usual = usual > LARGEST_BLOCK ? LARGEST_BLOCK : usual;
  usual = size > usual ? size : usual;
  struct km_arena_block *block = km_alloc(1, sizeof *block + ALIGNMENT + usual);
  if (!block)
    return false;
  block->previous = arena->block;
  block->size = usual;
  arena->block = block;
  return true;
}

void *km_arena_alloc(km_arena *arena, size_t count, size_t size) {
  if (!arena)
    return NULL;
  size_t bytes;
  if (arena->failed || __builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX / 2 - ALIGNMENT) {
    arena->failed = true;
    return NULL;
  }
  bytes = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
  if (!arena->block || arena->block->size - arena->block->used < bytes) {
    if (!new_block(arena, bytes)) {
      arena->failed = true;
      return NULL;
    }
  }
  void *result = block_start(arena->block) + arena->block->used;
  arena->block->used += bytes;
  return result;
}

char *km_arena_string(km_arena *arena, const char *text) {
  if (!arena || !text)
    return NULL;
  size_t size = strlen(text) + 1;
  char *copy = km_arena_alloc(arena, size, 1);
  if (copy)
    memcpy(copy, text, size);
  return copy;
}

static void free_blocks(struct km_arena_block *block) {
  while (block) {
    struct km_arena_block *previous = block->previous;
    km_free(block);
    block = previous;
  }
}

void km_arena_free(km_arena *arena) {
  if (!arena)
    return;
  free_blocks(arena->block);
  *arena = (km_arena){0};
}

km_arena km_arena_reuse(km_arena *memory) {
  km_arena arena = {0};
  if (memory) {
    arena = *memory;
    *memory = (km_arena){0};
  }
  return arena;
}

void km_arena_recycle(km_arena *arena, km_arena *memory) {
  struct km_arena_block *kept = arena->block; /* mostly the largest block */
  if (!memory || !kept) {
    km_arena_free(arena);
    return;
  }
  free_blocks(kept->previous);
  kept->previous = NULL;
  memset(block_start(kept), 0, kept->used);
  kept->used = 0;
  *memory = (km_arena){.block = kept};
  *arena = (km_arena){0};
}

void km_arena_merge(km_arena *arena, km_arena *from) {
  struct km_arena_block *first = from->block;
  while (first && first->previous)
    first = first->previous;
  if (first) {
    first->previous = arena->block;
    arena->block = from->block;
  }
  *from = (km_arena){0};
}

bool km_arena_grow(km_arena *arena, void **data, size_t *capacity, size_t need, size_t size) {
  if (need <= *capacity && *data)
    return true;
  size_t grown = need > 2 * *capacity ? need : 2 * *capacity;
  void *bigger = km_arena_alloc(arena, grown, size);
  if (!bigger)
    return false;
  if (*data)
    memcpy(bigger, *data, *capacity * size);
  *data = bigger;
  *capacity = grown;
  return true;
}

bool km_reserve(void **data, size_t *capacity, size_t need, size_t size) {
  if (!data || !capacity)
    return false;
  if (need <= *capacity)
    return true;
  size_t grown = *capacity + *capacity / 2 + 16;
  if (grown < need)
    grown = need;
  void *block = km_resize(*data, grown, size);
  if (!block)
    return false;
  *data = block;
  *capacity = grown;
  return true;
}
