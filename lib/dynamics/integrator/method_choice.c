/* The choice between Adams' method and BDF. */
#include "dynamics/integrator/method_choice.h"

#include <math.h>
#include <string.h>

/* A window is so many steps; a method's first ones, with which it finds its order and length of steps, don't count. */
enum { WINDOW = 100, FIRST_STEPS = 30 };
/* Windows within which a method has to prove better. */
enum { TRIAL = 2 };
/* Windows until the other method is tried; after every trial that fails as many more. */
static const int first_patience[2] = {1, 16};
/* How much further a rival has to go: Adams' higher orders serve a motion better that isn't stiff. */
static const double advantage[2] = {1.0, 1.5};
/* How fast an estimate of the largest rate fades. */
static const double memory = 0.95;
/* A difference below this part of the tolerances tells of rounding. */
static const double least = 1e-3;

double km_stability_limit(int order) {
  static const double limits[] = {2.0, 2.0, 2.26, 1.86, 1.4, 1.03, .78, .58, .44, .34, .26, .21, .06};
  return limits[order < 0 ? 0 : order > 12 ? 12 : order];
}

bool km_choice_create(km_choice *c, km_method method, bool bound, int size, km_arena *arena) {
  *c = (km_choice){.method = method, .bound = bound, .size = size, .time = -HUGE_VAL};
  memcpy(c->patience, first_patience, sizeof first_patience);
  c->y = KM_ARENA_NEW(arena, double, (size_t)size);
  c->f = KM_ARENA_NEW(arena, double, (size_t)size);
  c->window.y = KM_ARENA_NEW(arena, double, (size_t)size);
  c->window.f = KM_ARENA_NEW(arena, double, (size_t)size);
  return !arena->failed;
}

/* |f − f₀| / |y − y₀|; 0 where y has hardly changed. */
static double rate_of(const km_choice *c, const double *y0, const double *f0, const double *y, const double *f,
                      const double *tolerance) {
  double step = 0.0, change = 0.0;
  for (int i = 0; i < c->size; ++i) {
    double weight = 1.0 / tolerance[i], dy = weight * (y[i] - y0[i]), df = weight * (f[i] - f0[i]);
    step += dy * dy;
    change += df * df;
  }
  return step > least * least * c->size ? sqrt(change / step) : 0.0;
}

void km_choice_see(km_choice *c, double t, const double *y, const double *f, const double *tolerance) {
  if (c->bound || c->method != KM_ADAMS)
    return;
  if (t == c->time)
    c->largest = fmax(rate_of(c, c->y, c->f, y, f, tolerance), memory * c->largest);
  memcpy(c->y, y, (size_t)c->size * sizeof *y);
  memcpy(c->f, f, (size_t)c->size * sizeof *f);
  c->time = t;
}

/* Is it stability that keeps a step short? Up to order 3, accuracy alone doesn't let steps come near 0.2/ρ at any useful
 * tolerance. From order 4 on these are half of what the predictor, Adams and Bashforth's method, bears on the negative axis
 * (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, V.1), and accurate steps do come near them. */
enum { LOW_ORDER = 3 };
static bool is_strained(const km_choice *c, double h, int order) {
  static const double near[] = {.2, .2, .2, .2, .15, .0815, .0438, .0232, .0122, .0064, .0033, .0017, .0009};
  return h * c->largest > near[order];
}

/* Most steps have been short; those of high orders though the motion on the whole was far slower than its largest rate. */
static bool is_stiff(const km_choice *c, const double *tolerance) {
  enum { STRAINED = WINDOW * 7 / 10, LOW = WINDOW / 2 };
  static const double slower = 20.0;
  const km_window *w = &c->window;
  return w->strained >= STRAINED &&
         (w->low >= LOW || c->largest > slower * rate_of(c, w->y, w->f, c->y, c->f, tolerance));
}

static km_method other(km_method method) {
  return method == KM_ADAMS ? KM_BDF : KM_ADAMS;
}

static void open_window(km_choice *c, double time, double work) {
  km_window *w = &c->window;
  *w = (km_window){.y = w->y, .f = w->f, .time = time, .work = work};
  memcpy(w->y, c->y, (size_t)c->size * sizeof *w->y);
  memcpy(w->f, c->f, (size_t)c->size * sizeof *w->f);
}

/* At the end of a window. */
static bool rather_other(km_choice *c, double time, double work, const double *tolerance) {
  double pace = (time - c->window.time) / (work - c->window.work);
  c->windows++;
  if (c->rival > 0.0) {
    bool kept = pace > advantage[c->method] * c->rival;
    if (!kept && c->windows < TRIAL)
      return false;
    km_method rival = other(c->method);
    c->patience[rival] += kept ? 0 : first_patience[rival];
    c->rival = 0.0;
    return !kept;
  }
  if (c->windows < c->patience[c->method] || (c->method == KM_ADAMS && !is_stiff(c, tolerance)))
    return false;
  c->rival = pace;
  return true;
}

bool km_choice_step(km_choice *c, const km_taken_step *step, const double *tolerance) {
  if (c->bound)
    return false;
  c->window.strained += is_strained(c, step->length, step->order);
  c->window.low += step->order <= LOW_ORDER;
  c->steps++;
  if (c->steps < FIRST_STEPS || (c->steps - FIRST_STEPS) % WINDOW)
    return false;
  bool change = c->steps > FIRST_STEPS && rather_other(c, step->time, step->work, tolerance);
  open_window(c, step->time, step->work);
  return change;
}

bool km_choice_fail(km_choice *c) {
  bool tried = c->rival > 0.0;
  c->patience[other(c->method)] += tried ? first_patience[other(c->method)] : 0;
  c->rival = 0.0;
  return tried;
}

void km_choice_change(km_choice *c) {
  c->method = other(c->method);
  c->steps = 0;
  c->windows = 0;
  c->largest = 0.0;
  c->time = -HUGE_VAL;
}
