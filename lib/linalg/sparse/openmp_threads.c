/* Nesting level of OpenMP, set in the runtime that CHOLMOD has loaded. */
#include "linalg/sparse/openmp_threads.h"

#include "base/dynamic_library.h"

#include <stddef.h>

typedef struct library {
  int (*get_levels)(void);
  void (*set_levels)(int);
} library;

/* Loads the functions; NULL: no OpenMP, so no other threads. */
static const library *load_openmp(void) {
  static const char *const files[] = {"libgomp.so.1", NULL}, *const names[] = {"omp_get_max_active_levels",
                                                                               "omp_set_max_active_levels", NULL};
  static library functions;
  static km_library openmp = {files, names, &functions, false};
  return km_library_load(&openmp) ? NULL : &functions;
}

int km_openmp_single_thread_begin(void) {
  const library *openmp = load_openmp();
  int levels = openmp ? openmp->get_levels() : 0;
  if (openmp)
    openmp->set_levels(0); /* no parallel regions */
  return levels;
}

void km_openmp_single_thread_end(int levels) {
  const library *openmp = load_openmp();
  if (openmp)
    openmp->set_levels(levels);
}
