/* Coulomb friction by continuation in the load share t (theory 8.6).
 *
 *   r_c(N, t) = |a_c + t Σ_k B_ck N_k| - N_c = 0,   J = -dr/dN,   load(t) = 1 - t Σ w_k N_k
 *   predict   : N + h dN/dt,  J dN/dt = dr/dt;     correct : Newton's method at t + h
 *   accept    : correction <= 1/4 of the largest force, sign of det J unchanged (or h <= √ε) */
#include "transfer/coulomb_friction.h"
#include "base/number/tolerances.h"
#include "base/number/vectors.h"

#include "base/extrema.h"
#include "kinematics/loop_closing.h"

#include <float.h>
#include <string.h>

enum { MAX_ITERATIONS = 30, MAX_STEPS = 4000, STARTS = 8 };

/* Longest step in t over which the load is linear and det J may change its sign: the square is rounding. The shortest
 * step is shorter, and the correction of such a step longer, by km_significant_ratio. */
static double linear_step(void) {
  return sqrt(DBL_EPSILON);
}

static gsl_vector vector(km_arena *arena, int size) {
  return (gsl_vector){
      .size = (size_t)size, .stride = 1, .data = KM_ARENA_NEW(arena, double, (size_t)(size > 0 ? size : 1))};
}

bool km_friction_reserve(km_friction *f, int most, km_arena *arena) {
  size_t n = (size_t)(most > 0 ? most : 1);
  f->a = KM_ARENA_NEW(arena, double, 3 * n);
  f->B = KM_ARENA_NEW(arena, double, 3 * n * n);
  f->w = KM_ARENA_NEW(arena, double, n);
  f->N = KM_ARENA_NEW(arena, double, n);
  f->tried = KM_ARENA_NEW(arena, double, n);
  f->predicted = KM_ARENA_NEW(arena, double, n);
  f->slope = KM_ARENA_NEW(arena, double, n);
  f->J = (gsl_matrix){.data = KM_ARENA_NEW(arena, double, n *n)};
  f->rhs = vector(arena, most);
  f->step = vector(arena, most);
  f->pivots = KM_ARENA_NEW(arena, gsl_permutation, 1);
  size_t *places = KM_ARENA_NEW(arena, size_t, n);
  if (f->pivots)
    *f->pivots = (gsl_permutation){n, places};
  return !arena->failed;
}

static double remaining_load(const km_friction *f, double t, const double *N) {
  double dissipated = 0.0;
  for (int k = 0; k < f->count; ++k)
    dissipated += f->w[k] * N[k];
  return 1.0 - t * dissipated;
}

/* Computes the residuals r_c into rhs, J = −dr/dN, and dr/dt into `slope`. Returns the largest residual over its
 * largest term. */
static double linearise(km_friction *f, double t, const double *N) {
  double worst = 0.0, terms = 0.0;
  for (int c = 0; c < f->count; ++c) {
    double v[3], direction[3] = {0, 0, 0};
    for (int k = 0; k < f->count; ++k)
      for (int i = 0; i < 3; ++i) {
        direction[i] += f->B[3 * (c * f->count + k) + i] * N[k];
        terms = fmax(terms, fabs(t * f->B[3 * (c * f->count + k) + i] * N[k]));
      }
    for (int i = 0; i < 3; ++i) {
      v[i] = f->a[3 * c + i] + t * direction[i];
      terms = fmax(terms, fabs(f->a[3 * c + i]));
    }
    double size = hypot(hypot(v[0], v[1]), v[2]), inverse = size > 0.0 ? 1.0 / size : 0.0;
    for (int k = 0; k < f->count; ++k) {
      const double *b = f->B + 3 * (c * f->count + k);
      gsl_matrix_set(&f->J, (size_t)c, (size_t)k,
                     (c == k ? 1.0 : 0.0) - t * inverse * (v[0] * b[0] + v[1] * b[1] + v[2] * b[2]));
    }
    f->slope[c] = inverse * (v[0] * direction[0] + v[1] * direction[1] + v[2] * direction[2]);
    f->rhs.data[c] = size - N[c];
    worst = km_larger_or_nan(fabs(f->rhs.data[c]), worst);
  }
  return worst / terms;
}

/* Factors J in place (LU) and returns the sign of det J. */
static int factor_jacobian(km_friction *f) {
  int sign;
  gsl_linalg_LU_decomp(&f->J, f->pivots, &sign);
  return gsl_linalg_LU_sgndet(&f->J, sign);
}

/* Solves J step = rhs. Returns the sign of det J; 0: singular. */
static int solve_step(km_friction *f) {
  int sign = factor_jacobian(f);
  if (sign == 0)
    return 0;
  gsl_linalg_LU_solve(&f->J, f->pivots, &f->rhs, &f->step);
  return isfinite(km_max_norm(f->step.data, f->count)) ? sign : 0;
}

/* Adds the step to N and sets forces at rounding level to 0, whose direction is undefined. */
static void add_step(const km_friction *f, double *N) {
  for (int k = 0; k < f->count; ++k)
    N[k] += f->step.data[k];
  double rounding = km_sum_rounding * km_max_norm(N, f->count);
  for (int k = 0; k < f->count; ++k)
    N[k] = fabs(N[k]) <= rounding ? 0.0 : N[k];
}

/* Newton's method at t from the normal forces N; false if it fails. */
static bool newton_iterate(km_friction *f, double t, double *N) {
  for (int i = 0; i < MAX_ITERATIONS; ++i) {
    double residual = linearise(f, t, N);
    if (residual <= km_solved_rounding)
      return true;
    if (!isfinite(residual) || !solve_step(f))
      return false;
    add_step(f, N);
  }
  return false;
}

/* Predicts and corrects from the solution N at t to t + h on the same branch, into `tried`. The sign of det J changes
 * along a branch only at a turning point or a bifurcation; a change over a long step is a jump to another branch. */
static bool advance(km_friction *f, double t, double h) {
  size_t bytes = (size_t)f->count * sizeof *f->N;
  linearise(f, t, f->N);
  memcpy(f->rhs.data, f->slope, bytes);
  int sign_before = solve_step(f);
  for (int k = 0; k < f->count; ++k)
    f->predicted[k] = f->N[k] + (sign_before != 0 ? h * f->step.data[k] : 0.0);
  memcpy(f->tried, f->predicted, bytes);
  if (!newton_iterate(f, t + h, f->tried))
    return false;
  double correction = 0.0;
  for (int k = 0; k < f->count; ++k)
    correction = fmax(correction, fabs(f->tried[k] - f->predicted[k]));
  linearise(f, t + h, f->tried);
  bool sign_changed = factor_jacobian(f) != sign_before;
  return correction <= (sign_changed ? km_significant_ratio * linear_step() : km_correction_ratio) *
                           km_max_norm(f->N, f->count) &&
         !(sign_changed && h > linear_step());
}

/* Continues the solution from t = 0 towards 1; returns the last t. */
static double continue_solution(km_friction *f) {
  /* the digits of larger forces are those of the initial ones' rounding */
  const double largest_force = km_max_norm(f->N, f->count) / km_solved_rounding;
  double t = 0.0, h = 1.0;
  f->load = 1.0;
  f->locks_from = nan("");
  for (int i = 0; i < MAX_STEPS && t < 1.0 && h > linear_step() / km_significant_ratio &&
                  km_max_norm(f->N, f->count) < largest_force;
       ++i) {
    h = fmin(h, 1.0 - t);
    if (!advance(f, t, h)) {
      h *= 0.5;
      continue;
    }
    double load = remaining_load(f, t + h, f->tried);
    if (f->load > 0.0 && load <= 0.0) {
      if (h > linear_step()) {
        h *= 0.5;
        continue;
      }
      f->locks_from = t + h * f->load / (f->load - load);
    }
    memcpy(f->N, f->tried, (size_t)f->count * sizeof *f->N);
    f->load = load;
    t += h;
    h *= 2.0;
  }
  return t;
}

/* Searches a solution with all friction and positive load that the continuation does not reach, from starts of
 * several magnitudes. */
static bool find_detached_solution(km_friction *f) {
  double last = km_max_norm(f->N, f->count);
  for (int i = 0; i < STARTS; ++i) {
    for (int c = 0; c < f->count; ++c) {
      double without_friction = hypot(hypot(f->a[3 * c], f->a[3 * c + 1]), f->a[3 * c + 2]);
      f->tried[c] = (i % 2 ? f->N[c] + 0.01 * last : without_friction) * ldexp(1.0, i / 2);
    }
    if (newton_iterate(f, 1.0, f->tried) && (f->load = remaining_load(f, 1.0, f->tried)) > 0.0)
      return true;
  }
  return false;
}

km_friction_outcome km_friction_solve(km_friction *f) {
  size_t n = (size_t)f->count;
  f->load = 1.0;
  f->J.size1 = f->J.size2 = f->J.tda = f->rhs.size = f->step.size = f->pivots->size = n;
  for (int c = 0; c < f->count; ++c)
    f->N[c] = hypot(hypot(f->a[3 * c], f->a[3 * c + 1]), f->a[3 * c + 2]);
  if (km_max_norm(f->N, f->count) == 0.0)
    return KM_FRICTION_MOVES; /* no surface with friction is loaded */
  bool is_complete = continue_solution(f) >= 1.0;
  if (f->load <= 0.0)
    return KM_FRICTION_LOCKS;
  return is_complete || find_detached_solution(f) ? KM_FRICTION_MOVES : KM_FRICTION_OPEN;
}
