/* Joint friction by reactions during a motion (docs/theory.md 11.9).
 *
 *   F_c = −μ s(v) (slip arm) N_c(R),   R(q̈, F) reactions of a balance with inertia forces,   q̈ = q̈(F)
 *
 * Fixed-point iteration between friction, accelerations and reactions. */
#include "history/dynamic_friction.h"
#include "base/number/tolerances.h"

#include "transfer/friction_surfaces.h"

#include <string.h>

struct km_dynamic_friction {
  km_arena arena;
  km_dynamics *dynamics;
  km_statics statics;
  int count;
  km_surface *surface; /* [count] by coordinate */
  double *sum;         /* [coordinate] friction of all its surfaces */
  double *driving;     /* [coordinate] driving forces of prescribed motions; 0 elsewhere */
};

/* Largest number of iterations; change at convergence, relative to the sum of all forces. */
enum { MAX_ROUNDS = 100 };

/* Friction per unit of normal force, along the slip; its sign is that of the rate. */
static double coefficient_of(const km_mechanism *m, const km_state *s, int c) {
  const km_joint_friction *friction = &m->model->joints[m->model->coordinates[c].joint].friction;
  double speed = km_slip_speed(m, s->rate, c), arm = km_slip_arm(m, c);
  if (!(speed > 0.0))
    return 0.0;
  return friction->coefficient * km_slip_share(speed, km_stiction_speed(m, friction)) * arm * s->rate[c] / speed;
}

/* Computes the reactions of all joints at the present accelerations. */
static void find_reactions(km_dynamic_friction *w, km_state *s) {
  km_dynamics *d = w->dynamics;
  for (int c = 0; c < d->mechanism->coordinate_count; ++c)
    w->driving[c] = d->driven[c] ? km_dynamics_driving_force(d, s, c) : 0.0;
  km_dynamics_balance(d, s);
  km_statics_reactions_compute(d->mechanism, s, d->forces, w->driving, &w->statics);
}

/* Computes the friction of every coordinate at the present reactions; false: a screw thread jams. */
static bool sum_friction(km_dynamic_friction *w, const km_state *s) {
  const km_mechanism *m = w->dynamics->mechanism;
  for (int i = 0; i < w->count; ++i) {
    int c = w->surface[i].coordinate;
    double friction = coefficient_of(m, s, c);
    double normal = km_surface_normal(m, &w->statics, &w->surface[i], friction);
    if (!isfinite(normal))
      return false;
    bool first = i == 0 || w->surface[i - 1].coordinate != c;
    w->sum[c] = (first ? 0.0 : w->sum[c]) - friction * km_slip_arm(m, c) * normal;
  }
  return true;
}

/* Fixed-point iteration: reactions, friction, accelerations, until the friction changes by less than 1e-12 of all
 * forces. */
static km_dynamics_outcome iterate_friction(void *context, km_state *s) {
  km_dynamic_friction *w = context;
  km_dynamics *d = w->dynamics;
  double *friction = d->forces->moving->reaction_friction;
  for (int round = 0; round < MAX_ROUNDS; ++round) {
    double change = 0.0;
    find_reactions(w, s);
    if (!sum_friction(w, s))
      return KM_DYNAMICS_JAMMED;
    for (int i = 0; i < w->count; ++i) {
      int c = w->surface[i].coordinate;
      change = fmax(change, fabs(w->sum[c] - friction[c]) / km_slip_arm(d->mechanism, c));
      friction[c] = w->sum[c];
    }
    if (change <= km_solved_rounding * d->forces->force_size)
      return KM_DYNAMICS_DONE;
    km_dynamics_outcome outcome = km_dynamics_resolve(d, s);
    if (outcome != KM_DYNAMICS_DONE)
      return outcome;
  }
  return KM_DYNAMICS_JAMMED;
}

/* Allocates the arrays and attaches the friction to the equations of motion. */
static bool reserve(km_dynamic_friction *w) {
  const km_mechanism *m = w->dynamics->mechanism;
  size_t n = (size_t)m->coordinate_count;
  w->surface = KM_ARENA_NEW(&w->arena, km_surface, 2 * n);
  w->driving = KM_ARENA_NEW(&w->arena, double, n);
  w->sum = KM_ARENA_NEW(&w->arena, double, n);
  double *friction = KM_ARENA_NEW(&w->arena, double, n);
  if (w->arena.failed)
    return false;
  w->count = km_surfaces_list(m, w->surface);
  w->dynamics->forces->moving->reaction_friction = friction;
  w->dynamics->update_friction = iterate_friction;
  w->dynamics->friction_context = w;
  return true;
}

static bool has_friction(const km_mechanism *m) {
  for (int c = 0; c < m->coordinate_count; ++c)
    if (!m->held[c] && m->model->joints[m->model->coordinates[c].joint].friction.coefficient > 0.0 &&
        km_slip_arm(m, c) > 0.0)
      return true;
  return false;
}

km_status km_dynamic_friction_create(km_dynamics *d, km_dynamic_friction **out, km_error *error) {
  static const int none[1] = {0};
  *out = NULL;
  if (!has_friction(d->mechanism))
    return KM_OK;
  km_dynamic_friction *w = KM_NEW(km_dynamic_friction, 1);
  if (!w)
    return km_fail(error, KM_MEMORY, "out of memory for the friction");
  w->dynamics = d;
  km_status status = km_statics_create(d->mechanism, none, 0, KM_AXES_FIXED, &w->statics, error);
  if (!status && !reserve(w))
    status = km_fail(error, KM_MEMORY, "out of memory for the friction");
  if (status)
    km_dynamic_friction_free(w);
  else
    *out = w;
  return status;
}

void km_dynamic_friction_free(km_dynamic_friction *w) {
  if (!w)
    return;
  w->dynamics->forces->moving->reaction_friction = NULL;
  w->dynamics->update_friction = NULL;
  km_statics_free(&w->statics);
  km_arena_free(&w->arena);
  km_free(w);
}
