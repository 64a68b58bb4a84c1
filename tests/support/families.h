/* All families of random cases in one shape: a name and a check of the case that a seed makes. */
#ifndef KM_TESTS_FAMILIES_H
#define KM_TESTS_FAMILIES_H

#include <stdbool.h>
#include <stdint.h>

typedef struct family {
  const char *name;
  bool (*agrees)(uint64_t seed); /* false, with a line on stderr that says why, where the library is wrong */
} family;

/* Families by name; a NULL name at the end. */
extern const family all_families[];

#endif
