/* OpenMP's own setting, by the runtime that CHOLMOD has loaded. */
#include "linalg/sparse/openmp_threads.h"

#include "base/dynamic_library.h"

#include <stddef.h>

typedef struct library {
  int (*get_levels)(void);
  void (*set_levels)(int);
} library;

/* NULL: there is no OpenMP, and no other thread. */
static const library *load(void) {
  static const char *const files[] = {"libgomp.so.1", NULL}, *const names[] = {"omp_get_max_active_levels",
                                                                               "omp_set_max_active_levels", NULL};
  static library functions;
  static km_library openmp = {files, names, &functions, false};
  return km_library_load(&openmp) ? NULL : &functions;
}

int km_openmp_single_thread_begin(void) {
  const library *openmp = load();
  int levels = openmp ? openmp->get_levels() : 0;
  if (openmp)
    openmp->set_levels(0); /* of parallel regions within each other */
  return levels;
}

void km_openmp_single_thread_end(int levels) {
  const library *openmp = load();
  if (openmp)
    openmp->set_levels(levels);
}
