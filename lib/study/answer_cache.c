/* Hash table from designs to answers, with open addressing. Each answer is one block of memory. */
#include "study/answer_cache.h"

#include "base/memory.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

struct km_cached_answer {
  uint64_t hash;
  int question;
  km_design_outcome outcome;
  const char *reason;
  bool has_bands;
  double numbers[]; /* key, figures, bands */
};

/* FNV-1a by 64-bit words with the finaliser of MurmurHash3, because doubles differ mostly in their upper bits. */
static uint64_t hash(int question, const double *key, int count) {
  uint64_t h = 14695981039346656037u ^ (uint64_t)(unsigned)question;
  for (int i = 0; i < count; ++i) {
    uint64_t word;
    memcpy(&word, &key[i], sizeof word);
    h = (h ^ word) * 1099511628211u;
    h ^= h >> 32;
  }
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdu;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53u;
  return h ^ (h >> 33);
}

static bool matches(const km_cached_answer *a, uint64_t h, const km_store_shape *shape, const double *key) {
  return a->hash == h && a->question == shape->question &&
         memcmp(a->numbers, key, (size_t)shape->parameters * sizeof *key) == 0;
}

/* Slot of the design, or the empty slot for it (linear probing). */
static km_cached_answer **find_slot(const km_answer_cache *map, uint64_t h, const km_store_shape *shape,
                                    const double *key) {
  size_t i = h & (map->capacity - 1);
  while (map->slots[i] && !matches(map->slots[i], h, shape, key))
    i = (i + 1) & (map->capacity - 1);
  return &map->slots[i];
}

/* Doubles the table and reinserts all entries. */
static bool grow(km_answer_cache *map) {
  size_t capacity = map->capacity ? 2 * map->capacity : 64;
  km_cached_answer **slots = KM_NEW(km_cached_answer *, capacity);
  if (!slots)
    return false;
  for (size_t i = 0; i < map->capacity; ++i) {
    if (!map->slots[i])
      continue;
    size_t to = map->slots[i]->hash & (capacity - 1);
    while (slots[to])
      to = (to + 1) & (capacity - 1);
    slots[to] = map->slots[i];
  }
  km_free(map->slots);
  map->slots = slots;
  map->capacity = capacity;
  return true;
}

static bool has_bands(const km_store_shape *shape, const km_design_answer *a) {
  return shape->band_numbers && a->outcome <= KM_DESIGN_SHORT;
}

/* Copy of an answer in one block. */
static km_cached_answer *copy_answer(km_answer_cache *map, uint64_t h, const km_store_shape *shape, const double *key,
                                     const km_design_answer *a) {
  const size_t parameters = (size_t)shape->parameters, figures = (size_t)shape->figures;
  const size_t bands = has_bands(shape, a) ? (size_t)shape->band_numbers : 0;
  const size_t numbers = (parameters + figures + bands) * sizeof(double);
  km_cached_answer *copy = km_arena_alloc(&map->arena, 1, sizeof *copy + numbers);
  const char *reason = a->reason[0] ? km_arena_string(&map->arena, a->reason) : "";
  if (!copy || !reason)
    return NULL;
  *copy = (km_cached_answer){h, shape->question, a->outcome, reason, bands > 0};
  memcpy(copy->numbers, key, parameters * sizeof *key);
  memcpy(copy->numbers + parameters, a->figures, figures * sizeof *key);
  if (bands)
    memcpy(copy->numbers + parameters + figures, a->bands, bands * sizeof *key);
  return copy;
}

bool km_answer_cache_put(km_answer_cache *map, const km_store_shape *shape, const double *key,
                         const km_design_answer *answer) {
  if (2 * (map->count + 1) > map->capacity && !grow(map))
    return false;
  const uint64_t h = hash(shape->question, key, shape->parameters);
  km_cached_answer *copy = copy_answer(map, h, shape, key, answer), **at = find_slot(map, h, shape, key);
  if (!copy)
    return false;
  map->count += !*at;
  *at = copy;
  return true;
}

bool km_answer_cache_get(const km_answer_cache *map, const km_store_shape *shape, const double *key,
                         km_design_answer *out) {
  if (!map->capacity)
    return false;
  const km_cached_answer *cached = *find_slot(map, hash(shape->question, key, shape->parameters), shape, key);
  const size_t figures = (size_t)shape->figures;
  if (!cached)
    return false;
  const double *numbers = cached->numbers + shape->parameters;
  out->outcome = cached->outcome;
  snprintf(out->reason, sizeof out->reason, "%s", cached->reason);
  memcpy(out->figures, numbers, figures * sizeof *numbers);
  if (cached->has_bands && out->bands)
    memcpy(out->bands, numbers + figures, (size_t)shape->band_numbers * sizeof *numbers);
  return true;
}

void km_answer_cache_free(km_answer_cache *map) {
  km_arena_free(&map->arena);
  km_free(map->slots);
  *map = (km_answer_cache){0};
}
