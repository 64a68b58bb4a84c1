/* The surface on which a point moves (space/surface/point_motion.h). */
#include "space/surface/point_motion.h"

#include "base/number/vectors.h"
#include "base/random.h"
#include "kinematics/body_poses.h"

enum { PLACES = 48, STEPS = 200 };
static const double step_length = 0.2; /* |dq| */

/* Moves by a random step from a closed configuration. False: not closed. */
static bool step_at_random(km_driver_surface *f, double *N, uint64_t *random) {
  int sign, n = f->columns;
  double angle = M_PI * km_uniform(random), length;
  if (!km_driver_surface_close(f, step_length, &sign))
    return false;
  km_driver_surface_rates(f, N);
  for (int k = 0; k < n; ++k)
    f->step[k] = N[k] * cos(angle) + N[n + k] * sin(angle);
  length = km_norm(f->step, n);
  for (int k = 0; k < n; ++k)
    f->step[k] *= step_length / length;
  km_driver_surface_move(f, f->step);
  return km_driver_surface_close(f, step_length, &sign);
}

/* Places of the point along a random motion. Returns their number. */
static int sample_places(km_driver_surface *f, double *saved, double *N, km_vec3 *places) {
  uint64_t random = 7;
  int count = 0;
  for (int i = 0; i < STEPS && count < PLACES; ++i) {
    km_driver_surface_save(f, saved);
    if (!step_at_random(f, N, &random)) {
      km_driver_surface_restore(f, saved);
      continue;
    }
    km_poses_compute(f->m, f->s);
    places[count++] = km_driver_surface_place(f);
  }
  return count;
}

km_status km_point_motion_find_surface(km_driver_surface *f, km_error *error) {
  double normal[3];
  km_poses_compute(f->m, f->s);
  if (km_mechanism_plane(f->m, f->s, normal)) {
    km_point_surface_set_plane(&f->point_surface, km_vec3_from_array(normal), km_driver_surface_place(f));
    return KM_OK;
  }
  km_arena arena = {0};
  double *start = KM_ARENA_NEW(&arena, double, f->saved_size), *saved = KM_ARENA_NEW(&arena, double, f->saved_size),
         *N = KM_ARENA_NEW(&arena, double, 2 * (size_t)f->columns);
  km_vec3 places[PLACES];
  km_status status = arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the map") : KM_OK;
  if (!status) {
    km_driver_surface_save(f, start);
    int count = sample_places(f, saved, N, places);
    km_driver_surface_restore(f, start);
    status =
        count < PLACES
            ? km_fail(
                  error, KM_USAGE,
                  "the mechanism hardly moves from its pose; expected one with room to move, in which the surface of the point is found")
            : km_point_surface_fit(places, count, &f->point_surface, error);
  }
  km_arena_free(&arena);
  return status;
}
