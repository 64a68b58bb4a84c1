/* Loop over the substructures with progress and cancellation. */
#include "mobility/substructure_loop.h"

#include "kinematics/body_poses.h"
#include "mobility/mobility_numbers.h"

km_status km_each_substructure(const km_mechanism *m, km_substructure_visitor visit, void *self, km_progress progress,
                               void *context, const char *what, km_error *error) {
  int count = m->topology.substructure_count;
  for (int i = 0; i < count; ++i) {
    if (progress && !progress(context, (double)i / count))
      return km_fail(error, KM_CANCELLED, "the search for %s was cancelled", what);
    km_arena arena = {0};
    km_status status = visit(self, i, &arena, error);
    bool failed = arena.failed || status == KM_MEMORY;
    km_arena_free(&arena);
    if (failed)
      return km_fail(error, KM_MEMORY, "out of memory for %s", what);
    if (status)
      return status;
  }
  return KM_OK;
}

km_status km_search_substructures(const km_mechanism *m, km_state *s, km_substructure_visitor visit, void *self,
                                  km_progress progress, void *context, const char *what, km_error *error) {
  km_status status = km_check_state(m, s, error);
  km_mobility mobility;
  if (status)
    return status;
  km_poses_compute(m, s);
  km_ranks_update(m, s, KM_BASIS_ANY, &mobility);
  return km_each_substructure(m, visit, self, progress, context, what, error);
}
