/* Roots and minima of a function of one variable (event_locator.h).
 *
 *   estimate: s = (a f_b − b f_a)/(f_b − f_a), b the newest end
 *   where a stays twice: f_a is multiplied by 1 − f(s)/f_b, or by 1/2 if that is negative (Anderson, Björck) */
#include "base/event_locator.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>
#include <math.h>

enum { MAX_ITERATIONS = 100 };
enum { MAX_UNHALVED = 3 }; /* evaluations in which the bracket must halve: two of the method, one in reserve */

/* Part of the bracket to which a root is enclosed; the secant in it is accurate to the square. */
static const double enclosure = 1e-9;
/* Ratio of two successive steps that shows superlinear convergence: the next step is far below rounding then. At a
 * corner of f the steps shrink slowly, and the root is enclosed. */
static const double superlinear = 1e-3;

/* Computes the next position, at least one step from the newest end b, or ends the search. */
static void choose_position(km_root_search *search) {
  double width = fabs(search->b - search->a);
  if (width <= search->halved) {
    search->halved = 0.5 * width;
    search->unhalved = 0;
  }
  search->root = (search->a * search->fb - search->b * search->fa) / (search->fb - search->fa);
  double step = fabs(search->root - search->b);
  bool has_converged = step < search->step && step <= superlinear * search->last_step;
  search->open = search->iteration < MAX_ITERATIONS && width > 2.0 * search->step && !has_converged;
  if (search->open && search->unhalved++ >= MAX_UNHALVED)
    search->root = 0.5 * (search->a + search->b);
  else if (search->open && step < search->step)
    search->root = search->b + copysign(search->step, search->a - search->b);
  search->last_step = search->iteration > 0 ? fabs(search->root - search->b) : 0.0;
}

void km_root_search_begin(km_root_search *search, double a, double b, double fa, double fb) {
  double width = fabs(b - a);
  *search = (km_root_search){.a = a, .b = b, .fa = fa, .fb = fb, .halved = 0.5 * width};
  search->step = fmax(enclosure * width, 1e-15 * (fabs(a) + fabs(b)));
  choose_position(search);
}

void km_root_search_update(km_root_search *search, double f) {
  search->open = false;
  if (f == 0.0)
    return; /* `root` is exact */
  if (f * search->fb < 0.0) {
    search->a = search->b;
    search->fa = search->fb;
  } else {
    double shrink = 1.0 - f / search->fb;
    search->fa *= shrink > 0.0 ? shrink : 0.5;
  }
  search->b = search->root;
  search->fb = f;
  search->iteration++;
  choose_position(search);
}

double km_locate_root(km_event_function *f, void *context, double a, double b, double fa, double fb) {
  km_root_search search;
  km_root_search_begin(&search, a, b, fa, fb);
  while (search.open) {
    double value = f(search.root, context);
    if (isnan(value))
      break;
    km_root_search_update(&search, value);
  }
  return search.root;
}

/* Where f(s) equals the value of one bound, a unimodal function has its minimum between them: s moves there. */
static bool move_inside(km_event_function *f, void *context, km_minimum_bracket *b) {
  if (b->f < b->f_low && b->f < b->f_high)
    return true;
  bool is_low = b->f >= b->f_low;
  double middle = 0.5 * (b->s + (is_low ? b->low : b->high)), value = f(middle, context);
  if (!(value < b->f))
    return false;
  if (is_low) {
    b->high = b->s;
    b->f_high = b->f;
  } else {
    b->low = b->s;
    b->f_low = b->f;
  }
  b->s = middle;
  b->f = value;
  return true;
}

bool km_locate_minimum(km_event_function *f, void *context, double width, double enough, km_minimum_bracket *b) {
  gsl_function function = {f, context};
  gsl_set_error_handler_off();
  if (!move_inside(f, context, b))
    return false;
  gsl_min_fminimizer *solver = gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent);
  bool ok = solver && gsl_min_fminimizer_set_with_values(solver, &function, b->s, b->f, b->low, b->f_low, b->high,
                                                         b->f_high) == GSL_SUCCESS;
  for (int i = 0; i < MAX_ITERATIONS && ok && b->high - b->low > width && !(b->f < enough); ++i) {
    ok = gsl_min_fminimizer_iterate(solver) == GSL_SUCCESS; /* not where the function has no value */
    *b = (km_minimum_bracket){gsl_min_fminimizer_x_lower(solver),   gsl_min_fminimizer_f_lower(solver),
                              gsl_min_fminimizer_x_minimum(solver), gsl_min_fminimizer_f_minimum(solver),
                              gsl_min_fminimizer_x_upper(solver),   gsl_min_fminimizer_f_upper(solver)};
  }
  gsl_min_fminimizer_free(solver);
  return ok;
}

double km_locate_excursion(km_event_function *f, void *context, double a, double b, double fa, double fb,
                           double depth) {
  enum { PARTS = 8 };
  static const double width = 1e-8; /* relative: the minimum is known to the square of it */
  double h = (b - a) / PARTS, values[PARTS + 1];
  values[0] = fa;
  values[PARTS] = fb;
  int least = 0;
  for (int k = 1; k < PARTS; ++k) {
    values[k] = f(a + k * h, context);
    if (values[k] < -depth)
      return a + k * h;
    least = values[k] < values[least] ? k : least;
  }
  if (least == 0 || fb <= values[least])
    return HUGE_VAL;
  const double s = a + least * h;
  km_minimum_bracket bracket = {s - h, values[least - 1], s, values[least], s + h, values[least + 1]};
  km_locate_minimum(f, context, width * h, -depth, &bracket);
  return bracket.f < -depth ? bracket.s : HUGE_VAL;
}
