/* Rest configurations (equilibria): Newton's method on the accelerations, and pseudo-transient continuation to a
 * stable one (C. Kelley and D. Keyes 1998; docs/theory.md 11.13).
 *
 *   Newton   : K x = −a,  K = ∂a/∂u at rest, by SVD without singular values below 1e-10
 *   settling : (I/δ − K) x = a,  δ doubles while the accelerations do not grow */
#include "kmech/dynamics.h"

#include "base/arguments.h"
#include "base/extrema.h"
#include "dynamics/linearisation.h"
#include "linalg/dense/eigenvalues.h"

#include <gsl/gsl_linalg.h>
#include <string.h>

enum { MAX_STEPS = 60, MAX_SETTLING_STEPS = 2000, MAX_PERTURBATIONS = 10 };
static const double usual_max_step = 0.2; /* longest step, radians or characteristic lengths */
static const double linear_tolerance =
    1e-6;                                /* relative deviation from the predicted accelerations up to which longer steps
                                      * are allowed */
static const double at_rest = 1e-11;     /* Newton's method has converged below this step */
static const double max_residual = 1e-6; /* radians or characteristic lengths per s²: residual acceleration that no
                                      * motion removes */
static const double settled_acceleration = 1e-3; /* radians or characteristic lengths per s²: settling ends below this
                                      * acceleration */
static const double perturbation = 1e-2; /* perturbation away from an unstable configuration, radians or characteristic
                                      * lengths */

static void set_rates_to_zero(const km_mechanism *m, km_state *s) {
  memset(s->rate, 0, (size_t)m->coordinate_count * sizeof *s->rate);
}

/* Newton step x = −K⁺ a by SVD; singular values below 1e-10 of the largest are dropped (motions that change no
 * force). */
static bool newton_step(const double *K, const double *a, int f, double *x) {
  gsl_matrix *U = gsl_matrix_alloc((size_t)f, (size_t)f), *V = gsl_matrix_alloc((size_t)f, (size_t)f);
  gsl_vector *S = gsl_vector_alloc((size_t)f), *b = gsl_vector_alloc((size_t)f), *w = gsl_vector_alloc((size_t)f);
  gsl_vector_view out = gsl_vector_view_array(x, (size_t)f);
  bool is_ok = U && V && S && b && w;
  for (int r = 0; r < f && is_ok; ++r) {
    gsl_vector_set(b, (size_t)r, -a[r]);
    for (int c = 0; c < f; ++c)
      gsl_matrix_set(U, (size_t)r, (size_t)c, K[c * f + r]);
  }
  is_ok = is_ok && gsl_linalg_SV_decomp(U, V, S, w) == 0;
  for (int k = 1; k < f && is_ok; ++k)
    if (gsl_vector_get(S, (size_t)k) < 1e-10 * gsl_vector_get(S, 0))
      gsl_vector_set(S, (size_t)k, 0.0);
  is_ok = is_ok && gsl_linalg_SV_solve(U, V, S, b, &out.vector) == 0;
  gsl_matrix_free(U);
  gsl_matrix_free(V);
  gsl_vector_free(S);
  gsl_vector_free(b);
  gsl_vector_free(w);
  return is_ok;
}

/* Search for a rest configuration, and its last step. */
typedef struct rest_search {
  km_dynamics *d;
  km_state *s;
  km_stored_configuration stored; /* start of the step: freedom, independent coordinates, their accelerations */
  double *K, *x, *work;
  double max_step;               /* largest step allowed, scaled */
  double predicted_acceleration; /* largest acceleration predicted after a shortened step, scaled; 0: not shortened */
  double size;                   /* length of the step before shortening, scaled */
  double max_acceleration;       /* largest acceleration before the step, radians or characteristic lengths per s² */
  double residual;               /* largest residual acceleration that no step removes, and its coordinate */
  int coordinate;
} rest_search;

static double scaled_acceleration(const rest_search *e, int k, double acceleration) {
  const km_mechanism *m = e->d->mechanism;
  double second = 1.0 / m->model->units.time->si;
  return fabs(acceleration) * m->scale[e->stored.independent[k]] * second * second;
}

static void release(rest_search *e) {
  km_stored_configuration_free(&e->stored);
  km_free(e->K);
  km_free(e->x);
  km_free(e->work);
  e->stored = (km_stored_configuration){0};
  e->K = e->x = e->work = NULL;
}

/* Computes the accelerations at rest and K. KM_DIVERGED comes without a message; the caller adds it. */
static km_status evaluate_at_rest(rest_search *e, km_error *error) {
  set_rates_to_zero(e->d->mechanism, e->s);
  release(e);
  km_status status = km_dynamics_accelerate(e->d, e->s, error);
  if (status)
    return status;
  bool memory = km_stored_configuration_create(e->d, e->s, &e->stored);
  size_t f = (size_t)e->stored.freedom;
  e->K = KM_NEW(double, f *f + 1);
  e->x = KM_NEW(double, f + 1);
  e->work = KM_NEW(double, 2 * f + 1);
  if (!memory || !e->K || !e->x || !e->work)
    return km_fail(error, KM_MEMORY, "out of memory for a rest pose");
  e->max_acceleration = 0.0;
  for (int k = 0; k < e->stored.freedom; ++k) {
    e->stored.acceleration[k] = e->s->acceleration[e->stored.independent[k]];
    e->max_acceleration = fmax(e->max_acceleration, scaled_acceleration(e, k, e->stored.acceleration[k]));
  }
  return km_stiffness_of_accelerations(e->d, e->s, &e->stored, e->work, e->K) ? KM_OK : KM_DIVERGED;
}

/* Residual a + K x, reduced by its rounding error. */
static void compute_residual(rest_search *e) {
  int f = e->stored.freedom;
  e->residual = 0.0;
  for (int r = 0; r < f; ++r) {
    double sum = e->stored.acceleration[r], size = fabs(sum);
    for (int c = 0; c < f; ++c) {
      sum += e->K[c * f + r] * e->x[c];
      size += fabs(e->K[c * f + r]);
    }
    double residual = scaled_acceleration(e, r, fmax(fabs(sum) - 1e-9 * size, 0.0));
    if (residual > e->residual) {
      e->residual = residual;
      e->coordinate = e->stored.independent[r];
    }
  }
}

/* Step control: the longest step grows fourfold if a shortened step had the predicted effect (linear springs), else
 * it shrinks. */
static void adapt_reach(rest_search *e) {
  if (e->predicted_acceleration > 0.0 &&
      fabs(e->max_acceleration - e->predicted_acceleration) <= linear_tolerance * e->predicted_acceleration)
    e->max_step *= 4.0;
  else
    e->max_step = fmax(usual_max_step, 0.25 * e->max_step);
}

static double step_length(const rest_search *e) {
  double size = 0.0;
  for (int k = 0; k < e->stored.freedom; ++k)
    size = km_larger_or_nan(fabs(e->x[k]) * e->d->mechanism->scale[e->stored.independent[k]], size);
  return size;
}

/* Moves along x, shortened to the longest step, and predicts the accelerations after it. `shortened`: x itself was
 * shortened. False: not finite. */
static bool take_step(rest_search *e, bool shortened) {
  const km_mechanism *m = e->d->mechanism;
  int f = e->stored.freedom;
  e->size = step_length(e);
  double error_share = e->size > e->max_step ? e->max_step / e->size : 1.0;
  e->predicted_acceleration = 0.0;
  for (int r = 0; r < f && (shortened || error_share < 1.0); ++r) {
    double sum = e->stored.acceleration[r];
    for (int c = 0; c < f; ++c)
      sum += error_share * e->K[c * f + r] * e->x[c];
    e->predicted_acceleration = fmax(e->predicted_acceleration, scaled_acceleration(e, r, sum));
  }
  for (int k = 0; k < f && isfinite(e->size); ++k)
    km_coordinate_shift(m, e->s, e->stored.independent[k], error_share * e->x[k]);
  return isfinite(e->size);
}

/* One step of Newton's method. */
static km_status newton_iteration(rest_search *e, km_error *error) {
  km_status status = evaluate_at_rest(e, error);
  if (status)
    return status;
  adapt_reach(e);
  if (e->stored.freedom && !newton_step(e->K, e->stored.acceleration, e->stored.freedom, e->x))
    return KM_DIVERGED;
  compute_residual(e);
  return take_step(e, false) ? KM_OK : KM_DIVERGED;
}

/* Largest real part of K's eigenvalues; > 0: a deviation grows. */
static km_status fastest_growth(const rest_search *e, double *out, km_error *error) {
  size_t f = (size_t)e->stored.freedom;
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

/* Settling: implicit Euler steps of ẋ = a, (I/δ − K) x = a. Stiff parts don't limit the step. */
typedef struct settling_state {
  double delta;     /* time²; 0: not yet chosen */
  double last;      /* largest acceleration before the last step */
  km_state *before; /* state before the last step */
} settling_state;

/* Choice of δ: it doubles while the accelerations don't grow (pseudo-transient continuation, C. Kelley and D. Keyes
 * 1998), up to half the reciprocal of the largest growth rate, so that steps leave an unstable configuration. */
static km_status choose_delta(const rest_search *e, settling_state *f, km_error *error) {
  double growth, time = e->d->mechanism->model->units.time->si;
  km_status status = fastest_growth(e, &growth, error);
  if (status)
    return status;
  f->delta *= e->max_acceleration < 1.1 * f->last ? 2.0 : f->last / e->max_acceleration;
  f->delta = f->delta > 0.0 ? f->delta : usual_max_step / (e->max_acceleration * time * time);
  if (growth > 0.0)
    f->delta = fmin(f->delta, 0.5 / growth);
  return KM_OK;
}

/* Solves x = (I/δ − K)⁻¹ a. */
static bool solve_implicit(rest_search *e, double delta) {
  int f = e->stored.freedom;
  for (int k = 0; k < f; ++k)
    e->K[k * f + k] -= 1.0 / delta;
  bool solved = newton_step(e->K, e->stored.acceleration, f, e->x);
  for (int k = 0; k < f; ++k)
    e->K[k * f + k] += 1.0 / delta;
  return solved;
}

/* One settling step. KM_DIVERGED: no step is possible, or the last one increased the accelerations tenfold, as deep
 * in a stop. */
static km_status settle_step(rest_search *e, settling_state *f, km_error *error) {
  static const double far_greater = 10.0;
  km_status status = evaluate_at_rest(e, error);
  if (status || e->stored.freedom == 0 || e->max_acceleration <= settled_acceleration)
    return status;
  if (e->max_acceleration > far_greater * f->last)
    return KM_DIVERGED;
  adapt_reach(e);
  status = choose_delta(e, f, error);
  if (status)
    return status;
  km_state_copy(e->d->mechanism, f->before, e->s);
  f->last = e->max_acceleration;
  bool shortened = false;
  bool solved = solve_implicit(e, f->delta);
  for (double size = step_length(e); solved && size > e->max_step;
       size = step_length(e)) { /* δ is reduced instead of scaling x, so that soft parts don't slow down stiff ones */
    f->delta *= fmax(0.9 * e->max_step / size, 0.1);
    solved = solve_implicit(e, f->delta);
    shortened = true;
  }
  return solved && take_step(e, shortened) ? KM_OK : KM_DIVERGED;
}

/* Settling until the accelerations are small. A step that was too long is repeated with a tenth of δ. */
static km_status settle(rest_search *e, km_progress progress, void *context, km_error *error) {
  enum { MAX_RETRIES = 30 };
  settling_state f = {.last = HUGE_VAL};
  int retries = 0;
  km_status status = km_state_create(e->d->mechanism, &f.before, error);
  e->max_acceleration = HUGE_VAL;
  for (int i = 0; i < MAX_SETTLING_STEPS && !status && e->max_acceleration > settled_acceleration; ++i) {
    status = settle_step(e, &f, error);
    retries = status == KM_DIVERGED ? retries + 1 : 0;
    if (status == KM_DIVERGED && f.delta > 0.0 && retries < MAX_RETRIES) {
      km_state_copy(e->d->mechanism, e->s, f.before);
      f.delta *= 0.1;
      e->max_acceleration = HUGE_VAL;
      status = KM_OK;
    }
    if (!status && progress && !progress(context, (double)i / MAX_SETTLING_STEPS))
      status = km_fail(error, KM_CANCELLED, "cancelled while settling");
  }
  km_state_free(f.before);
  return status;
}

/* Newton's method. If a long step fails to close the loops, it is undone and short ones follow. */
static km_status find_by_newton(rest_search *e, km_error *error) {
  km_state *before = NULL;
  km_status status = km_state_create(e->d->mechanism, &before, error);
  e->size = HUGE_VAL;
  for (int i = 0; i < MAX_STEPS && !status && !(e->size <= at_rest); ++i) {
    bool far = e->max_step > usual_max_step;
    if (!far)
      km_state_copy(e->d->mechanism, before, e->s);
    status = newton_iteration(e, error);
    if (status == KM_DIVERGED && far) {
      km_state_copy(e->d->mechanism, e->s, before);
      e->max_step = usual_max_step;
      e->predicted_acceleration = 0.0;
      status = KM_OK;
    }
  }
  km_state_free(before);
  if (!status && !(e->size <= 1e3 * at_rest))
    status = km_fail(error, KM_NO_RESULT, "no rest pose was found from here");
  if (!status && e->residual > max_residual)
    status = km_fail(error, KM_NO_RESULT,
                     "no rest pose was found: nothing near here holds joint \"%s\" against what acts on it",
                     e->d->mechanism->model->coordinates[e->coordinate].label);
  return status;
}

/* Moves a small distance along the fastest growing mode. *unstable: the rest configuration was unstable. */
static km_status perturb(rest_search *e, bool *is_unstable, km_error *error) {
  const km_mechanism *m = e->d->mechanism;
  km_linear l;
  km_status status = km_linearise(e->d, e->s, &l, error);
  *is_unstable = !status && km_linear_stability(&l) == KM_UNSTABLE;
  int fastest = 0;
  for (int k = 1; k < 2 * l.freedom && *is_unstable; ++k)
    fastest = l.real[k] > l.real[fastest] ? k : fastest;
  for (int k = 0; k < l.freedom && *is_unstable; ++k) {
    int c = l.independent[k];
    km_coordinate_shift(m, e->s, c,
                        perturbation * l.modes[(size_t)fastest * 2 * (size_t)l.coordinate_count + (size_t)c]);
  }
  km_linear_free(&l);
  return status;
}

/* Finds a stable rest configuration: settling, Newton's method, and a perturbation from every unstable one. */
static km_status find_stable(rest_search *e, km_progress progress, void *context, km_error *error) {
  bool is_unstable = true;
  km_status status = KM_OK;
  for (int i = 0; i < MAX_PERTURBATIONS && is_unstable && !status; ++i) {
    status = settle(e, progress, context, error);
    if (!status)
      status = find_by_newton(e, error);
    if (!status)
      status = perturb(e, &is_unstable, error);
  }
  return status || !is_unstable ? status : km_fail(error, KM_NO_RESULT, "no stable rest pose was found from here");
}

/* Moves to the prescribed motions, then searches by Newton's method or settling. */
km_status km_equilibrium_find(km_dynamics *d, km_state *s, bool settles, km_progress progress, void *context,
                              km_error *error) {
  km_status status = km_check_given(d != NULL, "equations of motion", error);
  if (!status)
    status = km_check_state(d->mechanism, s, error);
  if (status)
    return status;
  status = km_dynamics_move_to_prescribed(d, s, error);
  if (status)
    return status;
  rest_search e = {.d = d, .s = s, .max_step = usual_max_step};
  status = settles ? find_stable(&e, progress, context, error) : find_by_newton(&e, error);
  release(&e);
  if (status == KM_DIVERGED)
    status = km_fail(error, KM_NO_RESULT, "no rest pose was found: the loops can't be closed on the way");
  if (!status || status == KM_NO_RESULT) {
    set_rates_to_zero(d->mechanism, s);
    km_dynamics_evaluate(d, s, true);
  }
  return status;
}
