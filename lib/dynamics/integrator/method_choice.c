/* Choice between Adams' method and BDF, by windows of steps (docs/theory.md 11.5).
 *
 *   ρ = |f − f₀| / |y − y₀|  of evaluations at one time;   a step h is limited by stability if h ρ > limit(order) */
#include "dynamics/integrator/method_choice.h"

#include <math.h>
#include <string.h>

/* Steps of a window, and first steps of a method that don't count because order and step length are still adapting. */
enum { WINDOW = 100, FIRST_STEPS = 30 };
/* Windows of a trial, in which a method must advance further than the other. */
enum { TRIAL = 2 };
/* Windows until the other method is tried; this number is added after every failed trial. */
static const int first_patience[2] = {1, 16};
/* Factor by which the tried method must advance further; larger for BDF, because Adams' higher orders are better for
 * motions that aren't stiff. */
static const double advantage[2] = {1.0, 1.5};
/* Decay of the estimate of the largest rate per evaluation. */
static const double memory = 0.95;
/* A difference below this part of the tolerances is rounding. */
static const double least = 1e-3;

double km_stability_limit(int order) {
  static const double limits[] = {2.0, 2.0, 2.26, 1.86, 1.4, 1.03, .78, .58, .44, .34, .26, .21, .06};
  return limits[order < 0 ? 0 : order > 12 ? 12 : order];
}

bool km_method_choice_create(km_method_choice *c, km_integration_method method, bool is_fixed, int size,
                             km_arena *arena) {
  *c = (km_method_choice){.method = method, .is_fixed = is_fixed, .size = size, .time = -HUGE_VAL};
  memcpy(c->patience, first_patience, sizeof first_patience);
  c->y = KM_ARENA_NEW(arena, double, (size_t)size);
  c->f = KM_ARENA_NEW(arena, double, (size_t)size);
  c->window.y = KM_ARENA_NEW(arena, double, (size_t)size);
  c->window.f = KM_ARENA_NEW(arena, double, (size_t)size);
  return !arena->failed;
}

/* Rate |f − f₀|/|y − y₀| in the weighted norm; 0 if y hardly changed. */
static double rate_of(const km_method_choice *c, const double *y0, const double *f0, const double *y, const double *f,
                      const double *tolerance) {
  double step = 0.0, change = 0.0;
  for (int i = 0; i < c->size; ++i) {
    double weight = 1.0 / tolerance[i], dy = weight * (y[i] - y0[i]), df = weight * (f[i] - f0[i]);
    step += dy * dy;
    change += df * df;
  }
  return step > least * least * c->size ? sqrt(change / step) : 0.0;
}

void km_method_choice_evaluation(km_method_choice *c, double t, const double *y, const double *f,
                                 const double *tolerance) {
  if (c->is_fixed || c->method != KM_ADAMS)
    return;
  if (t == c->time)
    c->largest = fmax(rate_of(c, c->y, c->f, y, f, tolerance), memory * c->largest);
  memcpy(c->y, y, (size_t)c->size * sizeof *y);
  memcpy(c->f, f, (size_t)c->size * sizeof *f);
  c->time = t;
}

/* True if stability limits the step: h ρ above limit(order). Accurate steps of orders up to 3 are far below 0.2/ρ.
 * For orders from 4 on, the limit is half the stability interval of the Adams-Bashforth predictor (E. Hairer and G.
 * Wanner 1996, V.1). */
enum { LOW_ORDER = 3 };
static bool is_stability_limited(const km_method_choice *c, double h, int order) {
  static const double near[] = {.2, .2, .2, .2, .15, .0815, .0438, .0232, .0122, .0064, .0033, .0017, .0009};
  return h * c->largest > near[order];
}

/* Stiffness test of a window: most steps were limited by stability, and half had a low order or ρ is 20 times the
 * mean rate. */
static bool is_stiff(const km_method_choice *c, const double *tolerance) {
  enum { STRAINED = WINDOW * 7 / 10, LOW = WINDOW / 2 };
  static const double slower = 20.0;
  const km_window *w = &c->window;
  return w->stability_limited >= STRAINED &&
         (w->low >= LOW || c->largest > slower * rate_of(c, w->y, w->f, c->y, c->f, tolerance));
}

static km_integration_method other(km_integration_method method) {
  return method == KM_ADAMS ? KM_BDF : KM_ADAMS;
}

static void open_window(km_method_choice *c, double time, double work) {
  km_window *w = &c->window;
  *w = (km_window){.y = w->y, .f = w->f, .time = time, .work = work};
  memcpy(w->y, c->y, (size_t)c->size * sizeof *w->y);
  memcpy(w->f, c->f, (size_t)c->size * sizeof *w->f);
}

/* Decision at the end of a window: true to change the method. */
static bool should_change(km_method_choice *c, double time, double work, const double *tolerance) {
  double progress = (time - c->window.time) / (work - c->window.work);
  c->windows++;
  if (c->rival_progress > 0.0) {
    bool kept_stages = progress > advantage[c->method] * c->rival_progress;
    if (!kept_stages && c->windows < TRIAL)
      return false;
    km_integration_method rival_progress = other(c->method);
    c->patience[rival_progress] += kept_stages ? 0 : first_patience[rival_progress];
    c->rival_progress = 0.0;
    return !kept_stages;
  }
  if (c->windows < c->patience[c->method] || (c->method == KM_ADAMS && !is_stiff(c, tolerance)))
    return false;
  c->rival_progress = progress;
  return true;
}

bool km_method_choice_step(km_method_choice *c, const km_step_record *step, const double *tolerance) {
  if (c->is_fixed)
    return false;
  c->window.stability_limited += is_stability_limited(c, step->length, step->order);
  c->window.low += step->order <= LOW_ORDER;
  c->steps++;
  if (c->steps < FIRST_STEPS || (c->steps - FIRST_STEPS) % WINDOW)
    return false;
  bool change = c->steps > FIRST_STEPS && should_change(c, step->time, step->work, tolerance);
  open_window(c, step->time, step->work);
  return change;
}

bool km_method_choice_failure(km_method_choice *c) {
  bool tried = c->rival_progress > 0.0;
  c->patience[other(c->method)] += tried ? first_patience[other(c->method)] : 0;
  c->rival_progress = 0.0;
  return tried;
}

void km_method_choice_change(km_method_choice *c) {
  c->method = other(c->method);
  c->steps = 0;
  c->windows = 0;
  c->largest = 0.0;
  c->time = -HUGE_VAL;
}
