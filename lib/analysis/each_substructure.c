/* The loop over substructures that the analyses of a pose share. */
#include "analysis/each_substructure.h"

km_status km_each_substructure(const km_mechanism *m, km_substructure_look look, void *self, km_progress progress,
                               void *context, const char *what, km_error *error) {
  int count = m->topology.substructure_count;
  for (int i = 0; i < count; ++i) {
    if (progress && !progress(context, (double)i / count))
      return km_fail(error, KM_CANCELLED, "the search for %s was cancelled", what);
    km_arena arena = {0};
    bool done = look(self, i, &arena) && !arena.failed;
    km_arena_free(&arena);
    if (!done)
      return km_fail(error, KM_MEMORY, "out of memory for %s", what);
  }
  return KM_OK;
}
