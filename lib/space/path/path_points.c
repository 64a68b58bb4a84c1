/* Configurations of a path in order (space/path/path_points.h). */
#include "space/path/path_points.h"

bool km_path_points_create(km_path_steps *g, double *const *saved, int count, km_arena *arena, km_path_points *out) {
  int n = g->f.columns;
  *out = (km_path_points){.saved = KM_ARENA_NEW(arena, double *, (size_t)count),
                          .x = KM_ARENA_NEW(arena, double, (size_t)count),
                          .q = KM_ARENA_NEW(arena, double, (size_t)count *(size_t)n)};
  if (arena->failed)
    return false;
  for (int i = 0; i < count; ++i) {
    int at = out->count;
    double *q = out->q + (size_t)at * (size_t)n;
    km_driver_surface_restore(&g->f, saved[i]);
    double length = at > 0 ? km_path_steps_difference(g, out->saved[at - 1]) : 0.0;
    if (at > 0 && length <= KM_EQUAL_PATH_CONFIGURATIONS)
      continue;
    out->x[at] = at > 0 ? out->x[at - 1] + length : 0.0;
    for (int k = 0; k < n; ++k) {
      int c = km_driver_surface_coordinate(&g->f, k);
      bool is_sum = at > 0 && g->f.m->ball_of[c] < 0; /* rotation vectors don't add up */
      q[k] = is_sum ? q[k - n] - g->towards[k] : g->f.s->q[c] / g->f.m->unit[c];
    }
    out->saved[out->count++] = saved[i];
  }
  return true;
}
