/* Solves the equations of Coulomb friction in a motion that is known. */
#include "transfer/coulomb_friction.h"

#include "base/extrema.h"

#include <string.h>

enum { MOST_NEWTON = 30, MOST_STEPS = 4000, STARTS = 8 };

static const double converged = 1e-13; /* of the terms that a normal force is made of */
static const double nothing = 1e-14;   /* of the largest normal force */
static const double shortest = 1e-10;  /* step in t */
static const double straight = 1e-8;   /* over such a step the load is a straight line */
static const double most_changed =
    0.25; /* of the largest normal force: a step that corrects more may change branches */
static const double most_changed_at_turns = 1e-6; /* the same over a short step where det J changes its sign */
static const double boundless = 1e12;             /* normal forces over those without friction */

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

/* Not a number where one isn't. */
static double largest(const double *x, int count) {
  double size = 0.0;
  for (int i = 0; i < count; ++i)
    size = km_larger_or_nan(fabs(x[i]), size);
  return size;
}

static double load_of(const km_friction *f, double t, const double *N) {
  double lost = 0.0;
  for (int k = 0; k < f->count; ++k)
    lost += f->w[k] * N[k];
  return 1.0 - t * lost;
}

/* Residuals |a_c + t Σ B_ck N_k| − N_c into rhs, the Jacobian of their opposite into J, and the residuals' change with
 * t into `slope`. Returns the largest residual over the terms that it is made of. */
static double linearise(km_friction *f, double t, const double *N) {
  double worst = 0.0, terms = 0.0;
  for (int c = 0; c < f->count; ++c) {
    double v[3], along[3] = {0, 0, 0};
    for (int k = 0; k < f->count; ++k)
      for (int i = 0; i < 3; ++i) {
        along[i] += f->B[3 * (c * f->count + k) + i] * N[k];
        terms = fmax(terms, fabs(t * f->B[3 * (c * f->count + k) + i] * N[k]));
      }
    for (int i = 0; i < 3; ++i) {
      v[i] = f->a[3 * c + i] + t * along[i];
      terms = fmax(terms, fabs(f->a[3 * c + i]));
    }
    double size = hypot(hypot(v[0], v[1]), v[2]), part = size > 0.0 ? 1.0 / size : 0.0;
    for (int k = 0; k < f->count; ++k) {
      const double *b = f->B + 3 * (c * f->count + k);
      gsl_matrix_set(&f->J, (size_t)c, (size_t)k,
                     (c == k ? 1.0 : 0.0) - t * part * (v[0] * b[0] + v[1] * b[1] + v[2] * b[2]));
    }
    f->slope[c] = part * (v[0] * along[0] + v[1] * along[1] + v[2] * along[2]);
    f->rhs.data[c] = size - N[c];
    worst = km_larger_or_nan(fabs(f->rhs.data[c]), worst);
  }
  return worst / terms;
}

/* The sign of det J, whose factors take J's place. */
static int factor(km_friction *f) {
  int sign;
  gsl_linalg_LU_decomp(&f->J, f->pivots, &sign);
  return gsl_linalg_LU_sgndet(&f->J, sign);
}

/* J step = rhs. Returns the sign of det J, 0: there is no such step. */
static int solve(km_friction *f) {
  int sign = factor(f);
  if (sign == 0)
    return 0;
  gsl_linalg_LU_solve(&f->J, f->pivots, &f->rhs, &f->step);
  return isfinite(largest(f->step.data, f->count)) ? sign : 0;
}

/* N + step. What only rounding leaves has no direction: where nothing presses it stays 0. */
static void take_step(const km_friction *f, double *N) {
  for (int k = 0; k < f->count; ++k)
    N[k] += f->step.data[k];
  double least = nothing * largest(N, f->count);
  for (int k = 0; k < f->count; ++k)
    N[k] = fabs(N[k]) <= least ? 0.0 : N[k];
}

/* Newton's method at t from the normal forces `N`, which it improves. */
static bool newton(km_friction *f, double t, double *N) {
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double residual = linearise(f, t, N);
    if (residual <= converged)
      return true;
    if (!isfinite(residual) || !solve(f))
      return false;
    take_step(f, N);
  }
  return false;
}

/* From the solution N at t to one on the same branch at t + h, into `tried`. Along a branch det J changes its sign only where it turns
 * back, or where another one leaves it: over a long step a change is a jump to another branch. */
static bool advance(km_friction *f, double t, double h) {
  size_t bytes = (size_t)f->count * sizeof *f->N;
  linearise(f, t, f->N);
  memcpy(f->rhs.data, f->slope, bytes);
  int before = solve(f);
  for (int k = 0; k < f->count; ++k)
    f->predicted[k] = f->N[k] + (before != 0 ? h * f->step.data[k] : 0.0);
  memcpy(f->tried, f->predicted, bytes);
  if (!newton(f, t + h, f->tried))
    return false;
  double changed = 0.0;
  for (int k = 0; k < f->count; ++k)
    changed = fmax(changed, fabs(f->tried[k] - f->predicted[k]));
  linearise(f, t + h, f->tried);
  bool turns = factor(f) != before;
  return changed <= (turns ? most_changed_at_turns : most_changed) * largest(f->N, f->count) &&
         !(turns && h > straight);
}

/* Follows the solution from t = 0 as far towards 1 as it goes; returns how far. */
static double follow(km_friction *f) {
  double t = 0.0, h = 1.0, usual = largest(f->N, f->count);
  f->load = 1.0;
  f->locks_from = nan("");
  for (int i = 0; i < MOST_STEPS && t < 1.0 && h > shortest && largest(f->N, f->count) < boundless * usual; ++i) {
    h = fmin(h, 1.0 - t);
    if (!advance(f, t, h)) {
      h *= 0.5;
      continue;
    }
    double load = load_of(f, t + h, f->tried);
    if (f->load > 0.0 && load <= 0.0) {
      if (h > straight) {
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

/* A solution with all friction and some load left that the motion from t = 0 doesn't lead to: from normal forces of
 * many sizes. */
static bool find_other(km_friction *f) {
  double last = largest(f->N, f->count);
  for (int i = 0; i < STARTS; ++i) {
    for (int c = 0; c < f->count; ++c) {
      double plain = hypot(hypot(f->a[3 * c], f->a[3 * c + 1]), f->a[3 * c + 2]);
      f->tried[c] = (i % 2 ? f->N[c] + 0.01 * last : plain) * ldexp(1.0, i / 2);
    }
    if (newton(f, 1.0, f->tried) && (f->load = load_of(f, 1.0, f->tried)) > 0.0)
      return true;
  }
  return false;
}

km_friction_answer km_friction_solve(km_friction *f) {
  size_t n = (size_t)f->count;
  f->load = 1.0;
  f->J.size1 = f->J.size2 = f->J.tda = f->rhs.size = f->step.size = f->pivots->size = n;
  for (int c = 0; c < f->count; ++c)
    f->N[c] = hypot(hypot(f->a[3 * c], f->a[3 * c + 1]), f->a[3 * c + 2]);
  if (largest(f->N, f->count) == 0.0)
    return KM_FRICTION_MOVES; /* nothing presses on anything that rubs */
  bool all = follow(f) >= 1.0;
  if (f->load <= 0.0)
    return KM_FRICTION_LOCKS;
  return all || find_other(f) ? KM_FRICTION_MOVES : KM_FRICTION_OPEN;
}
