/* Rest poses: Newton's method on accelerations, and settling by damping. */
#include "kmech/linear.h"

#include "base/check.h"
#include "dynamics/linear.h"

#include <gsl/gsl_linalg.h>
#include <string.h>

enum { MOST_STEPS = 60, SETTLING_STEPS = 20000 };
static const double longest = 0.2;   /* of a step: radians or characteristic lengths */
static const double at_rest = 1e-11; /* a Newton step below this ends */
static const double unheld = 1e-6;   /* radians or characteristic lengths per second², that no motion changes */
static const double settled = 1e-3;  /* speed per second, radians or characteristic lengths, that hardly moves */

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

/* A Newton step: its length, scaled, and the largest of the accelerations that no step takes away, in radians or characteristic
 * lengths per second², with its coordinate. */
typedef struct rest_step {
  double size, left;
  int coordinate;
} rest_step;

/* a + K x, beyond what rounding makes of it. */
static void see_left(const km_mechanism *m, const km_poise *p, const double *K, const double *x, rest_step *step) {
  double second = 1.0 / m->model->units.time->si;
  int f = p->freedom;
  step->left = 0.0;
  for (int r = 0; r < f; ++r) {
    double sum = p->acceleration[r], size = fabs(sum);
    for (int c = 0; c < f; ++c) {
      sum += K[c * f + r] * x[c];
      size += fabs(K[c * f + r]);
    }
    double left = (fabs(sum) - 1e-9 * size) * m->scale[p->independent[r]] * second * second;
    if (left > step->left)
      *step = (rest_step){step->size, left, p->independent[r]};
  }
}

/* One step. KM_OK, KM_DIVERGED, which its caller words, KM_MODEL … */
static km_status step_once(km_dynamics *d, km_state *s, rest_step *step, km_error *error) {
  const km_mechanism *m = d->mechanism;
  km_poise p = {0};
  stop(m, s);
  km_status status = km_dynamics_accelerate(d, s, error);
  if (status)
    return status;
  bool memory = km_poise_take(d, s, &p);
  size_t f = (size_t)p.freedom;
  double *K = KM_NEW(double, f *f + 1), *work = KM_NEW(double, 2 * f + 1), *x = KM_NEW(double, f + 1);
  memory = memory && K && work && x;
  bool good = memory;
  for (size_t k = 0; k < f && good; ++k)
    p.acceleration[k] = s->acceleration[p.independent[k]];
  good = good && km_stiffness_of_accelerations(d, s, &p, work, K) &&
         (f == 0 || newton_step(K, p.acceleration, p.freedom, x));
  step->size = 0.0;
  for (size_t k = 0; k < f && good; ++k)
    step->size = fmax(step->size, fabs(x[k]) * m->scale[p.independent[k]]);
  if (good)
    see_left(m, &p, K, x, step);
  double share = step->size > longest ? longest / step->size : 1.0;
  good = good && isfinite(step->size);
  for (size_t k = 0; k < f && good; ++k)
    km_nudge(m, s, p.independent[k], share * x[k]);
  km_free(K);
  km_free(work);
  km_free(x);
  km_poise_free(&p);
  if (!memory)
    return km_fail(error, KM_MEMORY, "out of memory for a rest pose");
  return good ? KM_OK : KM_DIVERGED;
}

/* Falls with a damping of all rates that grows with time, by steps of a part of a second. */
static km_status settle(km_dynamics *d, km_state *s, km_progress progress, void *context, km_error *error) {
  const km_mechanism *m = d->mechanism;
  double second = 1.0 / m->model->units.time->si, h = 2e-3 * second;
  stop(m, s);
  for (int i = 0; i < SETTLING_STEPS; ++i) {
    km_status status = km_dynamics_accelerate(d, s, error);
    double fastest = 0.0, hardest = 0.0;
    if (status)
      return status;
    for (int c = 0; c < m->coordinate_count; ++c) {
      s->rate[c] = (s->rate[c] + h * s->acceleration[c]) * 0.98;
      fastest = fmax(fastest, fabs(s->rate[c]) * m->scale[c] * second);
      hardest = fmax(hardest, fabs(s->acceleration[c]) * m->scale[c] * second * second);
    }
    if (i > 50 && fastest < settled && hardest < settled)
      return KM_OK;
    for (int c = 0; c < m->coordinate_count; ++c)
      if (m->ball_of[c] < 0)
        s->q[c] += h * s->rate[c];
    for (int b = 0; b < m->ball_count; ++b) {
      const double *w = &s->rate[m->ball_coordinate[b]];
      km_state_turn_ball(m, s, b, (km_vec3){h * w[0], h * w[1], h * w[2]});
    }
    if (progress && i % 256 == 0 && !progress(context, (double)i / SETTLING_STEPS))
      return km_fail(error, KM_CANCELLED, "cancelled while settling");
  }
  return KM_OK;
}

km_status km_equilibrium_find(km_dynamics *d, km_state *s, bool settles, km_progress progress, void *context,
                              km_error *error) {
  km_status status = km_check_given(d != NULL, "equations of motion", error);
  if (!status)
    status = km_check_state(d->mechanism, s, error);
  if (!status && settles)
    status = settle(d, s, progress, context, error);
  rest_step step = {.size = HUGE_VAL};
  for (int i = 0; i < MOST_STEPS && !status && !(step.size <= at_rest); ++i)
    status = step_once(d, s, &step, error);
  if (!status && !(step.size <= 1e3 * at_rest))
    status = km_fail(error, KM_NO_RESULT, "no rest pose was found from here");
  if (!status && step.left > unheld)
    status = km_fail(error, KM_NO_RESULT,
                     "no rest pose was found: nothing near here holds joint \"%s\" against what acts on it",
                     d->mechanism->model->coordinates[step.coordinate].label);
  if (status == KM_DIVERGED)
    status = km_fail(error, KM_NO_RESULT, "no rest pose was found: the loops can't be closed on the way");
  if (!status || status == KM_NO_RESULT) {
    stop(d->mechanism, s);
    km_dynamics_evaluate(d, s, true);
  }
  return status;
}
