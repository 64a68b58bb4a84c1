/* Rest poses: Newton's method on accelerations, and falling to a stable one. */
#include "kmech/dynamics.h"

#include "base/arguments.h"
#include "base/extrema.h"
#include "dynamics/linearisation.h"
#include "linalg/dense/eigenvalues.h"

#include <gsl/gsl_linalg.h>
#include <string.h>

enum { MOST_STEPS = 60, MOST_FALLING_STEPS = 2000, MOST_FALLS = 10 };
static const double longest = 0.2;   /* of a step: radians or characteristic lengths */
static const double straight = 1e-6; /* of the accelerations: what a step may miss where longer ones serve as well */
static const double at_rest = 1e-11; /* a Newton step below this ends */
static const double unheld = 1e-6;   /* radians or characteristic lengths per second², that no motion changes */
static const double settled = 1e-3;  /* the same, that hardly moves anything */
static const double push = 1e-2;     /* radians or characteristic lengths, away from a pose that isn't stable */

static void stop(const km_mechanism *m, km_state *s) {
  memset(s->rate, 0, (size_t)m->coordinate_count * sizeof *s->rate);
}

/* x = −K⁻¹ a by SVD: motions that change no force are left alone. */
static bool newton_step(const double *K, const double *a, int f, double *x) {
  gsl_matrix *U = gsl_matrix_alloc((size_t)f, (size_t)f), *V = gsl_matrix_alloc((size_t)f, (size_t)f);
  gsl_vector *S = gsl_vector_alloc((size_t)f), *b = gsl_vector_alloc((size_t)f), *w = gsl_vector_alloc((size_t)f);
  gsl_vector_view out = gsl_vector_view_array(x, (size_t)f);
  bool good = U && V && S && b && w;
  for (int r = 0; r < f && good; ++r) {
    gsl_vector_set(b, (size_t)r, -a[r]);
    for (int c = 0; c < f; ++c)
      gsl_matrix_set(U, (size_t)r, (size_t)c, K[c * f + r]);
  }
  good = good && gsl_linalg_SV_decomp(U, V, S, w) == 0;
  for (int k = 1; k < f && good; ++k)
    if (gsl_vector_get(S, (size_t)k) < 1e-10 * gsl_vector_get(S, 0))
      gsl_vector_set(S, (size_t)k, 0.0);
  good = good && gsl_linalg_SV_solve(U, V, S, b, &out.vector) == 0;
  gsl_matrix_free(U);
  gsl_matrix_free(V);
  gsl_vector_free(S);
  gsl_vector_free(b);
  gsl_vector_free(w);
  return good;
}

/* A search for a rest pose, and its last step. */
typedef struct search {
  km_dynamics *d;
  km_state *s;
  km_rest_pose poise; /* where the step began: freedom, independent coordinates, their accelerations */
  double *K, *x, *work;
  double reach;    /* no step is longer, scaled */
  double foretold; /* the largest acceleration that the step should have left, scaled; 0: it wasn't shortened */
  double size;     /* of the step before it was shortened, scaled */
  double hardest;  /* the largest acceleration before it, in radians or characteristic lengths per second² */
  double left;     /* the same of the accelerations that no step takes away, with its coordinate */
  int coordinate;
} search;

static double scaled_acceleration(const search *e, int k, double acceleration) {
  const km_mechanism *m = e->d->mechanism;
  double second = 1.0 / m->model->units.time->si;
  return fabs(acceleration) * m->scale[e->poise.independent[k]] * second * second;
}

static void forget(search *e) {
  km_poise_free(&e->poise);
  km_free(e->K);
  km_free(e->x);
  km_free(e->work);
  e->poise = (km_rest_pose){0};
  e->K = e->x = e->work = NULL;
}

/* Accelerations at rest and K there. KM_OK, KM_DIVERGED, which its caller words, KM_MODEL … */
static km_status look(search *e, km_error *error) {
  stop(e->d->mechanism, e->s);
  forget(e);
  km_status status = km_dynamics_accelerate(e->d, e->s, error);
  if (status)
    return status;
  bool memory = km_poise_take(e->d, e->s, &e->poise);
  size_t f = (size_t)e->poise.freedom;
  e->K = KM_NEW(double, f *f + 1);
  e->x = KM_NEW(double, f + 1);
  e->work = KM_NEW(double, 2 * f + 1);
  if (!memory || !e->K || !e->x || !e->work)
    return km_fail(error, KM_MEMORY, "out of memory for a rest pose");
  e->hardest = 0.0;
  for (int k = 0; k < e->poise.freedom; ++k) {
    e->poise.acceleration[k] = e->s->acceleration[e->poise.independent[k]];
    e->hardest = fmax(e->hardest, scaled_acceleration(e, k, e->poise.acceleration[k]));
  }
  return km_stiffness_of_accelerations(e->d, e->s, &e->poise, e->work, e->K) ? KM_OK : KM_DIVERGED;
}

/* a + K x, beyond what rounding makes of it. */
static void see_left(search *e) {
  int f = e->poise.freedom;
  e->left = 0.0;
  for (int r = 0; r < f; ++r) {
    double sum = e->poise.acceleration[r], size = fabs(sum);
    for (int c = 0; c < f; ++c) {
      sum += e->K[c * f + r] * e->x[c];
      size += fabs(e->K[c * f + r]);
    }
    double left = scaled_acceleration(e, r, fmax(fabs(sum) - 1e-9 * size, 0.0));
    if (left > e->left) {
      e->left = left;
      e->coordinate = e->poise.independent[r];
    }
  }
}

/* Where a step that was shortened has left what it should have, longer ones serve as well: a spring is far from its rest. */
static void adapt_reach(search *e) {
  if (e->foretold > 0.0 && fabs(e->hardest - e->foretold) <= straight * e->foretold)
    e->reach *= 4.0;
  else
    e->reach = fmax(longest, 0.25 * e->reach);
}

static double size_of(const search *e) {
  double size = 0.0;
  for (int k = 0; k < e->poise.freedom; ++k)
    size = km_larger_or_nan(fabs(e->x[k]) * e->d->mechanism->scale[e->poise.independent[k]], size);
  return size;
}

/* Goes along x as far as the reach allows. `shortened`: it is shorter already than it might be. False where it isn't finite. */
static bool move(search *e, bool shortened) {
  const km_mechanism *m = e->d->mechanism;
  int f = e->poise.freedom;
  e->size = size_of(e);
  double share = e->size > e->reach ? e->reach / e->size : 1.0;
  e->foretold = 0.0;
  for (int r = 0; r < f && (shortened || share < 1.0); ++r) {
    double sum = e->poise.acceleration[r];
    for (int c = 0; c < f; ++c)
      sum += share * e->K[c * f + r] * e->x[c];
    e->foretold = fmax(e->foretold, scaled_acceleration(e, r, sum));
  }
  for (int k = 0; k < f && isfinite(e->size); ++k)
    km_nudge(m, e->s, e->poise.independent[k], share * e->x[k]);
  return isfinite(e->size);
}

/* A step of Newton's method. */
static km_status step_once(search *e, km_error *error) {
  km_status status = look(e, error);
  if (status)
    return status;
  adapt_reach(e);
  if (e->poise.freedom && !newton_step(e->K, e->poise.acceleration, e->poise.freedom, e->x))
    return KM_DIVERGED;
  see_left(e);
  return move(e, false) ? KM_OK : KM_DIVERGED;
}

/* The largest real part of K's eigenvalues: > 0 where a deviation grows. */
static km_status fastest_growth(const search *e, double *out, km_error *error) {
  size_t f = (size_t)e->poise.freedom;
  double *A = KM_NEW(double, f *f), *vectors = KM_NEW(double, f *f), *real = KM_NEW(double, 2 * f);
  km_status status = A && vectors && real ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a rest pose");
  if (!status) {
    memcpy(A, e->K, f * f * sizeof *A);
    status = km_eigen((int)f, A, real, real + f, NULL, vectors, error);
  }
  *out = -HUGE_VAL;
  for (size_t k = 0; k < f && !status; ++k)
    *out = fmax(*out, real[k]);
  km_free(A);
  km_free(vectors);
  km_free(real);
  return status;
}

/* Falling: steps of ẋ = a by Euler's implicit method, (I/δ − K) x = a. Stiff parts don't shorten them. */
typedef struct falling {
  double delta;     /* time², 0: not yet chosen */
  double last;      /* `hardest` before the last step */
  km_state *before; /* where the last step began */
} falling;

/* δ grows while the accelerations don't (C. Kelley, D. Keyes, Convergence analysis of pseudo-transient continuation, 1998), but stays so
 * short that steps lead away from a pose that isn't stable. */
static km_status choose_delta(const search *e, falling *f, km_error *error) {
  double growth, time = e->d->mechanism->model->units.time->si;
  km_status status = fastest_growth(e, &growth, error);
  if (status)
    return status;
  f->delta *= e->hardest < 1.1 * f->last ? 2.0 : f->last / e->hardest;
  f->delta = f->delta > 0.0 ? f->delta : longest / (e->hardest * time * time);
  if (growth > 0.0)
    f->delta = fmin(f->delta, 0.5 / growth);
  return KM_OK;
}

/* x = (I/δ − K)⁻¹ a */
static bool solve_implicit(search *e, double delta) {
  int f = e->poise.freedom;
  for (int k = 0; k < f; ++k)
    e->K[k * f + k] -= 1.0 / delta;
  bool solved = newton_step(e->K, e->poise.acceleration, f, e->x);
  for (int k = 0; k < f; ++k)
    e->K[k * f + k] += 1.0 / delta;
  return solved;
}

/* KM_DIVERGED: no step can be made from here, or the last one has led to far greater accelerations, as deep in a stop. */
static km_status fall_once(search *e, falling *f, km_error *error) {
  static const double far_greater = 10.0;
  km_status status = look(e, error);
  if (status || e->poise.freedom == 0 || e->hardest <= settled)
    return status;
  if (e->hardest > far_greater * f->last)
    return KM_DIVERGED;
  adapt_reach(e);
  status = choose_delta(e, f, error);
  if (status)
    return status;
  km_state_copy(e->d->mechanism, f->before, e->s);
  f->last = e->hardest;
  bool shortened = false;
  bool solved = solve_implicit(e, f->delta);
  for (double size = size_of(e); solved && size > e->reach;
       size = size_of(e)) { /* soft parts then don't hold up stiff ones */
    f->delta *= fmax(0.9 * e->reach / size, 0.1);
    solved = solve_implicit(e, f->delta);
    shortened = true;
  }
  return solved && move(e, shortened) ? KM_OK : KM_DIVERGED;
}

/* Falls until hardly anything accelerates. Behind a step that was too long a shorter one is made. */
static km_status fall(search *e, km_progress progress, void *context, km_error *error) {
  enum { MOST_RETRIES = 30 };
  falling f = {.last = HUGE_VAL};
  int retries = 0;
  km_status status = km_state_create(e->d->mechanism, &f.before, error);
  e->hardest = HUGE_VAL;
  for (int i = 0; i < MOST_FALLING_STEPS && !status && e->hardest > settled; ++i) {
    status = fall_once(e, &f, error);
    retries = status == KM_DIVERGED ? retries + 1 : 0;
    if (status == KM_DIVERGED && f.delta > 0.0 && retries < MOST_RETRIES) {
      km_state_copy(e->d->mechanism, e->s, f.before);
      f.delta *= 0.1;
      e->hardest = HUGE_VAL;
      status = KM_OK;
    }
    if (!status && progress && !progress(context, (double)i / MOST_FALLING_STEPS))
      status = km_fail(error, KM_CANCELLED, "cancelled while settling");
  }
  km_state_free(f.before);
  return status;
}

/* Newton's method. From a step that was too long for the loops it goes back, and on by short ones. */
static km_status find(search *e, km_error *error) {
  km_state *before = NULL;
  km_status status = km_state_create(e->d->mechanism, &before, error);
  e->size = HUGE_VAL;
  for (int i = 0; i < MOST_STEPS && !status && !(e->size <= at_rest); ++i) {
    bool far = e->reach > longest;
    if (!far)
      km_state_copy(e->d->mechanism, before, e->s);
    status = step_once(e, error);
    if (status == KM_DIVERGED && far) {
      km_state_copy(e->d->mechanism, e->s, before);
      e->reach = longest;
      e->foretold = 0.0;
      status = KM_OK;
    }
  }
  km_state_free(before);
  if (!status && !(e->size <= 1e3 * at_rest))
    status = km_fail(error, KM_NO_RESULT, "no rest pose was found from here");
  if (!status && e->left > unheld)
    status = km_fail(error, KM_NO_RESULT,
                     "no rest pose was found: nothing near here holds joint \"%s\" against what acts on it",
                     e->d->mechanism->model->coordinates[e->coordinate].label);
  return status;
}

/* Goes a little along the mode that grows fastest. `left`: it is at rest in a pose that isn't stable. */
static km_status push_away(search *e, bool *left, km_error *error) {
  const km_mechanism *m = e->d->mechanism;
  km_linear l;
  km_status status = km_linearise(e->d, e->s, &l, error);
  *left = !status && km_linear_stability(&l) == KM_UNSTABLE;
  int fastest = 0;
  for (int k = 1; k < 2 * l.freedom && *left; ++k)
    fastest = l.real[k] > l.real[fastest] ? k : fastest;
  for (int k = 0; k < l.freedom && *left; ++k) {
    int c = l.independent[k];
    km_nudge(m, e->s, c, push * l.modes[(size_t)fastest * 2 * (size_t)l.coordinate_count + (size_t)c]);
  }
  km_linear_free(&l);
  return status;
}

/* A stable pose, by falling from every other one that it comes to. */
static km_status find_stable(search *e, km_progress progress, void *context, km_error *error) {
  bool left = true;
  km_status status = KM_OK;
  for (int i = 0; i < MOST_FALLS && left && !status; ++i) {
    status = fall(e, progress, context, error);
    if (!status)
      status = find(e, error);
    if (!status)
      status = push_away(e, &left, error);
  }
  return status || !left ? status : km_fail(error, KM_NO_RESULT, "no stable rest pose was found from here");
}

km_status km_equilibrium_find(km_dynamics *d, km_state *s, bool settles, km_progress progress, void *context,
                              km_error *error) {
  km_status status = km_check_given(d != NULL, "equations of motion", error);
  if (!status)
    status = km_check_state(d->mechanism, s, error);
  if (status)
    return status;
  status = km_dynamics_bring(d, s, error);
  if (status)
    return status;
  search e = {.d = d, .s = s, .reach = longest};
  status = settles ? find_stable(&e, progress, context, error) : find(&e, error);
  forget(&e);
  if (status == KM_DIVERGED)
    status = km_fail(error, KM_NO_RESULT, "no rest pose was found: the loops can't be closed on the way");
  if (!status || status == KM_NO_RESULT) {
    stop(d->mechanism, s);
    km_dynamics_evaluate(d, s, true);
  }
  return status;
}
