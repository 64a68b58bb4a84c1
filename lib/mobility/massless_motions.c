/* Generalised masses of free motions (theory 6.7): G_kl = Σ m v_k · v_l + ω_kᵀ I ω_l over all bodies; singular if a
 * motion moves no mass. */
#include "mobility/massless_motions.h"
#include "base/number/tolerances.h"

#include "kinematics/body_poses.h"
#include "spatial/inertia.h"

/* A free motion: rates and velocities. */
typedef struct motion {
  double *rates;             /* [coordinate] */
  km_vec3 *v, *w, *momentum; /* [body] velocity of the centre of mass, angular velocity, I ω; 0 for massless bodies */
} motion;

/* Returns I ω along the inertial axes. */
static km_vec3 angular_momentum(const km_model_body *body, const km_rotation *R, km_vec3 w) {
  const double *I = body->inertia;
  return km_rotate(R, km_symmetric_times(&(km_symmetric){I[0], I[1], I[2], I[3], I[4], I[5]}, km_rotate_back(R, w)));
}

/* Computes the velocities of all bodies for a null vector z of D · range(N). */
static void compute_motion(const km_mechanism *m, const km_state *s, int index, const double *z, km_arena *arena,
                           motion *out) {
  const km_substructure *sub = &m->substructures[index];
  size_t bodies = (size_t)m->topology.body_count;
  *out = (motion){KM_ARENA_NEW(arena, double, (size_t)m->coordinate_count), KM_ARENA_NEW(arena, km_vec3, bodies),
                  KM_ARENA_NEW(arena, km_vec3, bodies), KM_ARENA_NEW(arena, km_vec3, bodies)};
  if (arena->failed)
    return;
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    out->rates[c] = z[k] / m->scale[c];
  }
  for (int b = 1; b < m->topology.body_count; ++b) {
    const km_model_body *body = &m->model->bodies[b];
    if (body->mass == 0.0)
      continue;
    km_twist t = km_body_twist(m, s, b, out->rates);
    out->v[b] = km_point_velocity(t, km_pose_point(&s->pose[b], body->center_of_mass));
    out->w[b] = t.w;
    out->momentum[b] = angular_momentum(body, &s->pose[b].R, t.w);
  }
}

/* Returns G_ab of two motions. */
static double generalised_mass(const km_mechanism *m, const motion *a, const motion *b) {
  double sum = 0.0;
  for (int i = 1; i < m->topology.body_count; ++i)
    sum += m->model->bodies[i].mass * km_vec3_dot(a->v[i], b->v[i]) + km_vec3_dot(a->w[i], b->momentum[i]);
  return sum;
}

/* True if the matrix G is singular. */
static bool has_singular_masses(const km_mechanism *m, const motion *motions, int freedom, km_arena *arena) {
  km_factor *p = km_factor_create(freedom, freedom, NULL, arena);
  double *G = KM_ARENA_NEW(arena, double, (size_t)freedom *(size_t)freedom);
  if (arena->failed)
    return false;
  for (int k = 0; k < freedom; ++k)
    for (int l = 0; l < freedom; ++l)
      G[(size_t)k * (size_t)freedom + (size_t)l] = generalised_mass(m, &motions[k], &motions[l]);
  km_factor_compute(p, G, freedom, freedom, &(km_factor_options){.tolerance = km_relative_zero});
  return km_factor_rank(p) < freedom;
}

km_status km_has_massless_motion(const km_mechanism *m, km_state *s, int index, bool *is_massless, km_error *error) {
  km_arena arena = {0};
  const double *Z = km_state_basis(s, index);
  int freedom = km_factor_freedom(s->factor[index]), columns = m->substructures[index].columns;
  motion *motions = KM_ARENA_NEW(&arena, motion, (size_t)freedom);
  for (int k = 0; k < freedom && motions; ++k)
    compute_motion(m, s, index, Z + (size_t)k * (size_t)columns, &arena, &motions[k]);
  *is_massless = freedom > 0 && !arena.failed && has_singular_masses(m, motions, freedom, &arena);
  bool failed = arena.failed;
  km_arena_free(&arena);
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the masses of motions") : KM_OK;
}
