/* Dead points of a coordinate (theory 10.3): roots of its entry z_j in the unit direction of motion D q̇/|D q̇|.
 *
 *   sign change  : regula falsi, Illinois variant
 *   no change    : minimum of |z_j| by Brent's method where a parabola shows one near 0; then two roots or a
 *                  touching root */
#include "sweep/dead_points.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>
#include <math.h>

/* The root is found if the next step is below this part of the interval: the error of regula falsi is then far
 * smaller. */
static const double root_tolerance = 1e-9;
/* Relative distance of the bounds of a minimum at which the search ends; its value is known to the square of it. */
static const double minimum_tolerance = 1e-6;

enum { MAX_ITERATIONS = 60 };

/* Computes the next position, or ends the search. */
static void choose_position(km_root_search *search) {
  double last = search->root;
  search->open =
      search->iteration < MAX_ITERATIONS && fabs(search->b - search->a) > 1e-13 * (fabs(search->a) + fabs(search->b));
  if (!search->open)
    return;
  search->root = (search->a * search->fb - search->b * search->fa) / (search->fb - search->fa);
  search->open = search->iteration <= 1 || fabs(search->root - last) >= root_tolerance * search->width;
}

void km_root_search_begin(km_root_search *search, double a, double b, double fa, double fb) {
  *search = (km_root_search){.a = a, .b = b, .fa = fa, .fb = fb, .root = b, .width = fabs(b - a)};
  choose_position(search);
}

void km_root_search_update(km_root_search *search, double f) {
  search->open = false;
  if (fabs(f) < 1e-14)
    return;
  if (f * search->fb < 0.0) {
    search->a = search->b;
    search->fa = search->fb;
  } else {
    search->fa *= 0.5;
  }
  search->b = search->root;
  search->fb = f;
  search->iteration++;
  choose_position(search);
}

bool km_minimum_search_may_reach_zero(const km_minimum_search *samples, double *lowest) {
  const double *s = samples->s, *f = samples->f;
  if (!(f[0] * f[1] > 0.0 && f[1] * f[2] > 0.0))
    return false;
  double a = fabs(f[0]), b = fabs(f[1]), c = fabs(f[2]);
  double first = (b - a) / (s[1] - s[0]), second = (c - b) / (s[2] - s[1]);
  double curvature = (second - first) / (s[2] - s[0]), slope = first + curvature * (s[1] - s[0]);
  *lowest = s[1] - 0.5 * slope / curvature;
  double least = b - 0.25 * slope * slope / curvature;
  return curvature > 0.0 && (*lowest - s[0]) * (*lowest - s[2]) < 0.0 &&
         least < km_batch_minimum_ratio * fmin(a, fmin(b, c));
}

/* The entry as a function for GSL, with the sign that makes it positive in the samples. */
typedef struct entry {
  km_sweeper *r;
  int coordinate;
  double sign;
  bool is_lost; /* a configuration was not reached */
} entry;

static double entry_at(double s, void *context) {
  entry *e = context;
  km_sweeper *r = e->r;
  r->is_batched = false; /* the motion is single from here on */
  e->is_lost = e->is_lost || !r->mover.probe(r->mover.self, s, r->rates);
  if (e->is_lost)
    return (double)NAN; /* ends the search */
  km_unit_direction(r->m, r->rates, r->scratch);
  return e->sign * r->scratch[e->coordinate];
}

/* A bracket of a minimum: the entry at `middle` is below both bounds. */
typedef struct bracket {
  double low, f_low, search, f, high, f_high;
} bracket;

/* Finds the bracket of the minimum that the parabola shows; false if the entry has none. */
static bool find_bracket(entry *e, const km_minimum_search *samples, double lowest, bracket *t) {
  double s[4] = {samples->s[0], samples->s[1], samples->s[2], lowest}, f[4];
  for (int i = 0; i < 3; ++i)
    f[i] = fabs(samples->f[i]);
  f[3] = entry_at(lowest, e);
  for (int i = 1; i < 4; ++i) /* sorted by position */
    for (int k = i; k > 0 && s[k] < s[k - 1]; --k) {
      double position = s[k], value = f[k];
      s[k] = s[k - 1];
      f[k] = f[k - 1];
      s[k - 1] = position;
      f[k - 1] = value;
    }
  int i = f[2] < f[1] ? 2 : 1;
  *t = (bracket){s[i - 1], f[i - 1], s[i], f[i], s[i + 1], f[i + 1]};
  return t->f < t->f_low && t->f < t->f_high;
}

/* Minimises the coordinate's entry of the unit direction of motion, signed to be positive, by Brent's method; stops
 * at a sign change (two dead points) or at the minimum (a touching one). False if a configuration was not reached. */
static bool minimise(entry *e, bracket *t) {
  gsl_function f = {entry_at, e};
  double shortest = minimum_tolerance * (t->high - t->low);
  gsl_min_fminimizer *solver = gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent);
  bool ok = solver && gsl_min_fminimizer_set_with_values(solver, &f, t->search, t->f, t->low, t->f_low, t->high,
                                                         t->f_high) == GSL_SUCCESS;
  for (int k = 0; k < MAX_ITERATIONS && ok && t->f > 0.0; ++k) {
    ok = gsl_min_fminimizer_iterate(solver) == GSL_SUCCESS && !e->is_lost;
    *t = (bracket){gsl_min_fminimizer_x_lower(solver),   gsl_min_fminimizer_f_lower(solver),
                   gsl_min_fminimizer_x_minimum(solver), gsl_min_fminimizer_f_minimum(solver),
                   gsl_min_fminimizer_x_upper(solver),   gsl_min_fminimizer_f_upper(solver)};
    ok = ok && t->high - t->low > shortest;
  }
  gsl_min_fminimizer_free(solver);
  return !e->is_lost;
}

/* Returns the root between two positions with different signs. */
static double find_root(entry *e, double a, double fa, double b, double fb) {
  km_root_search search;
  km_root_search_begin(&search, a, b, fa, fb);
  while (search.open) {
    double f = entry_at(search.root, e);
    if (e->is_lost)
      break;
    km_root_search_update(&search, f);
  }
  return search.root;
}

double km_dead_point_between(km_sweeper *r, const km_directions *d, int i, int c) {
  entry e = {r, c, 1.0, false};
  return find_root(&e, d->s[i], km_directions_entry(d, i, c), d->s[i + 1], km_directions_entry(d, i + 1, c));
}

int km_minimum_search_find(km_sweeper *r, int coordinate, const km_minimum_search *samples, double lowest,
                           double roots[2]) {
  entry e = {r, coordinate, samples->f[1] < 0.0 ? -1.0 : 1.0, false};
  bracket t;
  gsl_set_error_handler_off();
  if (!find_bracket(&e, samples, lowest, &t) || !minimise(&e, &t))
    return 0;
  roots[0] = t.search;
  if (t.f > -km_zero_entry) /* touching root, or no root */
    return t.f < km_zero_entry;
  roots[0] = find_root(&e, t.low, t.f_low, t.search, t.f);
  roots[1] = find_root(&e, t.high, t.f_high, t.search, t.f);
  return 2;
}
