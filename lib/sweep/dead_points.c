/* Dead points of a coordinate: roots of its entry in the direction of motion, and those that no change of sign shows. */
#include "sweep/dead_points.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>
#include <math.h>

/* A root is found where the next place would be nearer than this part of the interval: the places before it were that near
 * already, and the errors of regula falsi multiply. */
static const double found = 1e-9;
/* How near to each other the bounds of a least value come, as part of the rows' distance: it is known to the square of it. */
static const double nearest = 1e-6;

enum { MOST_ROUNDS = 60 };

/* The next place of the search, or none where the root is found. */
static void choose_place(km_root_search *at) {
  double last = at->root;
  at->open = at->round < MOST_ROUNDS && fabs(at->b - at->a) > 1e-13 * (fabs(at->a) + fabs(at->b));
  if (!at->open)
    return;
  at->root = (at->a * at->fb - at->b * at->fa) / (at->fb - at->fa);
  at->open = at->round <= 1 || fabs(at->root - last) >= found * at->width;
}

void km_root_search_begin(km_root_search *at, double a, double b, double fa, double fb) {
  *at = (km_root_search){.a = a, .b = b, .fa = fa, .fb = fb, .root = b, .width = fabs(b - a)};
  choose_place(at);
}

void km_root_search_narrow(km_root_search *at, double f) {
  at->open = false;
  if (fabs(f) < 1e-14)
    return;
  if (f * at->fb < 0.0) {
    at->a = at->b;
    at->fa = at->fb;
  } else {
    at->fa *= 0.5;
  }
  at->b = at->root;
  at->fb = f;
  at->round++;
  choose_place(at);
}

bool km_minimum_search_is_zero(const km_minimum_search *dip, double *lowest) {
  const double *s = dip->s, *f = dip->f;
  if (!(f[0] * f[1] > 0.0 && f[1] * f[2] > 0.0))
    return false;
  double a = fabs(f[0]), b = fabs(f[1]), c = fabs(f[2]);
  double first = (b - a) / (s[1] - s[0]), second = (c - b) / (s[2] - s[1]);
  double bend = (second - first) / (s[2] - s[0]), slope = first + bend * (s[1] - s[0]);
  *lowest = s[1] - 0.5 * slope / bend;
  double least = b - 0.25 * slope * slope / bend;
  return bend > 0.0 && (*lowest - s[0]) * (*lowest - s[2]) < 0.0 &&
         least < km_batch_minimum_ratio * fmin(a, fmin(b, c));
}

/* The entry as GSL sees it, by its sign at the places that show the dip. */
typedef struct entry {
  km_sweeper *r;
  int coordinate;
  double sign;
  bool lost; /* a pose can't be reached */
} entry;

static double entry_at(double s, void *context) {
  entry *e = context;
  km_sweeper *r = e->r;
  r->rides = false; /* from here on the drive goes alone */
  e->lost = e->lost || !r->mover.probe(r->mover.self, s, r->rates);
  if (e->lost)
    return (double)NAN; /* ends the search */
  km_unit_direction(r->m, r->rates, r->scratch);
  return e->sign * r->scratch[e->coordinate];
}

/* A place where the entry is less than at both bounds. */
typedef struct trough {
  double low, f_low, at, f, high, f_high;
} trough;

/* The trough that the parabola shows; false where the entry has none there. */
static bool find_trough(entry *e, const km_minimum_search *dip, double lowest, trough *t) {
  double s[4] = {dip->s[0], dip->s[1], dip->s[2], lowest}, f[4];
  for (int i = 0; i < 3; ++i)
    f[i] = fabs(dip->f[i]);
  f[3] = entry_at(lowest, e);
  for (int i = 1; i < 4; ++i) /* by place */
    for (int k = i; k > 0 && s[k] < s[k - 1]; --k) {
      double place = s[k], value = f[k];
      s[k] = s[k - 1];
      f[k] = f[k - 1];
      s[k - 1] = place;
      f[k - 1] = value;
    }
  int i = f[2] < f[1] ? 2 : 1;
  *t = (trough){s[i - 1], f[i - 1], s[i], f[i], s[i + 1], f[i + 1]};
  return t->f < t->f_low && t->f < t->f_high;
}

/* Goes down into the trough until the entry has changed its sign, or is least. By Brent's method. */
static bool go_down(entry *e, trough *t) {
  gsl_function f = {entry_at, e};
  double near = nearest * (t->high - t->low);
  gsl_min_fminimizer *solver = gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent);
  bool goes_on = solver && gsl_min_fminimizer_set_with_values(solver, &f, t->at, t->f, t->low, t->f_low, t->high,
                                                              t->f_high) == GSL_SUCCESS;
  for (int k = 0; k < MOST_ROUNDS && goes_on && t->f > 0.0; ++k) {
    goes_on = gsl_min_fminimizer_iterate(solver) == GSL_SUCCESS && !e->lost;
    *t = (trough){gsl_min_fminimizer_x_lower(solver),   gsl_min_fminimizer_f_lower(solver),
                  gsl_min_fminimizer_x_minimum(solver), gsl_min_fminimizer_f_minimum(solver),
                  gsl_min_fminimizer_x_upper(solver),   gsl_min_fminimizer_f_upper(solver)};
    goes_on = goes_on && t->high - t->low > near;
  }
  gsl_min_fminimizer_free(solver);
  return !e->lost;
}

/* Between two places where the entry has different signs. */
static double find_root(entry *e, double a, double fa, double b, double fb) {
  km_root_search at;
  km_root_search_begin(&at, a, b, fa, fb);
  while (at.open) {
    double f = entry_at(at.root, e);
    if (e->lost)
      break;
    km_root_search_narrow(&at, f);
  }
  return at.root;
}

double km_dead_point_between(km_sweeper *r, const km_directions *d, int i, int c) {
  entry e = {r, c, 1.0, false};
  return find_root(&e, d->s[i], km_directions_entry(d, i, c), d->s[i + 1], km_directions_entry(d, i + 1, c));
}

int km_minimum_search_find(km_sweeper *r, int coordinate, const km_minimum_search *dip, double lowest,
                           double roots[2]) {
  entry e = {r, coordinate, dip->f[1] < 0.0 ? -1.0 : 1.0, false};
  trough t;
  gsl_set_error_handler_off();
  if (!find_trough(&e, dip, lowest, &t) || !go_down(&e, &t))
    return 0;
  roots[0] = t.at;
  if (t.f > -km_dead) /* it touches 0, or stays away from it */
    return t.f < km_dead;
  roots[0] = find_root(&e, t.low, t.f_low, t.at, t.f);
  roots[1] = find_root(&e, t.high, t.f_high, t.at, t.f);
  return 2;
}
