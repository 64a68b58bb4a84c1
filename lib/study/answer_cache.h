/* Answers about designs in memory, by request and parameter values: a hash table. Private to study/. */
#ifndef KM_STUDY_ANSWER_CACHE_H
#define KM_STUDY_ANSWER_CACHE_H

#include "study/result_store.h"

typedef struct km_cached_answer km_cached_answer;

/* Hash table; zero-initialised it is empty. */
typedef struct km_answer_cache {
  km_arena arena;
  km_cached_answer **slots; /* NULL: empty */
  size_t capacity;          /* 0 or a power of two */
  size_t count;
} km_answer_cache;

/* Stores a copy of the answer, replacing an earlier one, in O(1). `key`: parameter values as km_entry_store
 * normalises them. False: out of memory. */
bool km_answer_cache_put(km_answer_cache *map, const km_store_shape *shape, const double *key,
                         const km_design_answer *answer);
/* Copies the answer to `out`, whose figures and bands must be allocated. False: not found. */
bool km_answer_cache_get(const km_answer_cache *map, const km_store_shape *shape, const double *key,
                         km_design_answer *out);
void km_answer_cache_free(km_answer_cache *map);

#endif
