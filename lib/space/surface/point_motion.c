/* The surface on which a point moves (space/surface/point_motion.h). */
#include "space/surface/point_motion.h"

#include "base/number/vectors.h"
#include "base/random.h"
#include "kinematics/body_poses.h"

enum { PLACES = 48, STEPS = 200 };
static const double step_length = 0.2;  /* |dq| */
static const double least_speed = 1e-6; /* σ: rounding leaves 1e-16 to 1e-10, surfaces of models/ have more than 1e-2 */

/* Places along a random motion, and how the point moves there. */
typedef struct random_motion {
  km_vec3 places[PLACES];
  int count;
  double fastest, second; /* largest σ_1 and σ_2 of all places, over the size */
} random_motion;

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

/* Orthonormal tangents at the factors of A. */
static void find_tangents(km_driver_surface *f, double *N) {
  int n = f->columns;
  km_driver_surface_rates(f, N);
  for (int d = 0; d < 2; ++d) {
    double part = d == 0 ? 0.0 : km_dot(N, N + n, n), length;
    for (int k = 0; k < n; ++k)
      N[d * n + k] -= part * N[k];
    length = km_norm(N + d * n, n);
    for (int k = 0; k < n; ++k)
      N[d * n + k] /= length;
  }
}

/* Velocity of the point over the size. */
static km_vec3 velocity(const km_driver_surface *f, const double *dq) {
  km_vec3 v = {0.0, 0.0, 0.0};
  for (int k = 0; k < f->columns; ++k) {
    int c = km_driver_surface_coordinate(f, k);
    v = km_vec3_axpy(dq[k] * f->m->unit[c] / f->size, km_vec3_from_array(f->frame_jacobian + 6 * c), v);
  }
  return v;
}

/* Adds the present place. */
static void add_place(km_driver_surface *f, double *N, random_motion *motion) {
  km_poses_compute(f->m, f->s);
  motion->places[motion->count++] = km_driver_surface_place(f);
  km_frame_jacobian(f->m, f->s, f->frame, f->frame_jacobian, NULL);
  find_tangents(f, N);
  km_vec3 a = velocity(f, N), b = velocity(f, N + f->columns);
  double sum = km_vec3_dot(a, a) + km_vec3_dot(b, b), product = km_vec3_norm(km_vec3_cross(a, b));
  double first = sqrt(0.5 * sum + sqrt(fmax(0.25 * sum * sum - product * product, 0.0)));
  motion->fastest = fmax(motion->fastest, first);
  if (first > 0.0)
    motion->second = fmax(motion->second, product / first);
}

static void move_at_random(km_driver_surface *f, double *saved, double *N, random_motion *motion) {
  uint64_t random = 7;
  for (int i = 0; i < STEPS && motion->count < PLACES; ++i) {
    km_driver_surface_save(f, saved);
    if (step_at_random(f, N, &random))
      add_place(f, N, motion);
    else
      km_driver_surface_restore(f, saved);
  }
}

/* KM_USAGE: the point rests at all places, or moves along a curve. */
static km_status check_motion(const km_driver_surface *f, const random_motion *motion, km_error *error) {
  if (motion->count < PLACES || motion->second > least_speed)
    return KM_OK;
  const km_model *model = f->m->model;
  const km_model_frame *frame = &model->frames[f->frame];
  bool rests = motion->fastest <= least_speed;
  return km_fail(error, KM_USAGE, "point \"%s/%s\" %s; expected one that both drivers move",
                 model->bodies[frame->body].name, frame->name,
                 rests ? "rests while the drivers move" : "moves along a curve, which has no area");
}

static km_status fit_surface(km_driver_surface *f, const random_motion *motion, km_error *error) {
  double normal[3];
  if (km_mechanism_plane(f->m, f->s, normal)) {
    km_point_surface_set_plane(&f->point_surface, km_vec3_from_array(normal), km_driver_surface_place(f));
    return KM_OK;
  }
  return motion->count < PLACES
             ? km_fail(
                   error, KM_USAGE,
                   "the drivers hardly move the mechanism at its pose, so that the surface of the point isn't found; "
                   "expected another pose")
             : km_point_surface_fit(motion->places, motion->count, &f->point_surface, error);
}

km_status km_point_motion_find_surface(km_driver_surface *f, km_error *error) {
  km_arena arena = {0};
  double *start = KM_ARENA_NEW(&arena, double, f->saved_size), *saved = KM_ARENA_NEW(&arena, double, f->saved_size),
         *N = KM_ARENA_NEW(&arena, double, 2 * (size_t)f->columns);
  random_motion motion = {.count = 0};
  km_status status = arena.failed ? km_fail(error, KM_MEMORY, "out of memory for the map") : KM_OK;
  if (!status) {
    km_driver_surface_save(f, start);
    move_at_random(f, saved, N, &motion);
    km_driver_surface_restore(f, start);
    km_poses_compute(f->m, f->s);
    status = check_motion(f, &motion, error);
  }
  if (!status)
    status = fit_surface(f, &motion, error);
  km_arena_free(&arena);
  return status;
}
