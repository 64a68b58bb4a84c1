/* Location of the roots and minima of a function of one variable: the one place where events are located (theory 10.1).
 *
 *   root   : f(a) f(b) < 0;  regula falsi of Anderson and Björck, bisection where the bracket does not halve
 *   minimum: f(low) >= f(s) <= f(high);  Brent's method of parabolas and golden sections (GSL)
 *
 * Sources: N. Anderson and Å. Björck 1973; R. Brent 1973. */
#ifndef KM_BASE_EVENT_LOCATOR_H
#define KM_BASE_EVENT_LOCATOR_H

#include <stdbool.h>

/* Search for a root between a and b with opposite signs of f(a) and f(b): while `open`, the function's value at `root`
 * is required; then `root` is the result. The caller evaluates, so that several searches can advance together. */
typedef struct km_root_search {
  double a, b, fa, fb, root;
  double step;             /* least step from the newest end of the bracket; the search ends within two of them */
  double last_step;        /* last step of the estimate; 0: none */
  double halved;           /* width of the bracket at which it counts as halved, */
  int iteration, unhalved; /* and the number of evaluations since */
  bool open;
} km_root_search;

void km_root_search_begin(km_root_search *search, double a, double b, double fa, double fb);
/* Updates the search with the function's value f at `root`. */
void km_root_search_update(km_root_search *search, double f);

/* A function of one variable; NaN where it has no value, which ends a search. */
typedef double km_event_function(double s, void *context);

/* Root between a and b; the last estimate where the function has no value. */
double km_locate_root(km_event_function *f, void *context, double a, double b, double fa, double fb);

/* Bracket of a minimum: f(s) is at most both bounds' values; low < s < high. */
typedef struct km_minimum_bracket {
  double low, f_low, s, f, high, f_high;
} km_minimum_bracket;

/* Narrows the bracket of a minimum until high − low is at most `width`, or until f(s) is below `enough`. False where
 * the function has no value, or without memory; the bracket then holds what was found. */
bool km_locate_minimum(km_event_function *f, void *context, double width, double enough, km_minimum_bracket *bracket);

/* A place between a and b at which the function is below −depth although it isn't at the ends: eight samples, then the
 * minimum among them. Infinity: none. */
double km_locate_excursion(km_event_function *f, void *context, double a, double b, double fa, double fb, double depth);

#endif
