/* Hash table from scoped names to numbers. */
#include "base/name_map.h"

#include "base/memory.h"

#include <stdint.h>
#include <string.h>

void km_names_free(km_names *names) {
  km_free(names->entries);
  *names = (km_names){0};
}

/* FNV-1a hash. */
static size_t hash(int scope, const char *name) {
  uint64_t h = 14695981039346656037u ^ (uint64_t)(unsigned)scope;
  h *= 1099511628211u;
  for (const char *c = name; *c; ++c)
    h = (h ^ (unsigned char)*c) * 1099511628211u;
  return (size_t)(h ^ (h >> 29));
}

/* The entry of the name, or the empty entry where it belongs. The capacity is a power of two. */
static km_name_entry *slot(const km_names *names, int scope, const char *name) {
  size_t i = hash(scope, name) & (names->capacity - 1);
  while (names->entries[i].name && (names->entries[i].scope != scope || strcmp(names->entries[i].name, name) != 0))
    i = (i + 1) & (names->capacity - 1);
  return &names->entries[i];
}

static bool grow(km_names *names) {
  km_names bigger = {.capacity = names->capacity ? 2 * names->capacity : 64, .count = names->count};
  bigger.entries = KM_NEW(km_name_entry, bigger.capacity);
  if (!bigger.entries)
    return false;
  for (size_t i = 0; i < names->capacity; ++i)
    if (names->entries[i].name)
      *slot(&bigger, names->entries[i].scope, names->entries[i].name) = names->entries[i];
  km_free(names->entries);
  *names = bigger;
  return true;
}

bool km_names_set(km_names *names, int scope, const char *name, int value) {
  if (2 * (names->count + 1) > names->capacity && !grow(names))
    return false;
  km_name_entry *entry = slot(names, scope, name);
  if (!entry->name)
    names->count++;
  *entry = (km_name_entry){name, scope, value};
  return true;
}

int km_names_get(const km_names *names, int scope, const char *name) {
  if (!names->capacity)
    return -1;
  const km_name_entry *entry = slot(names, scope, name);
  return entry->name ? entry->value : -1;
}
