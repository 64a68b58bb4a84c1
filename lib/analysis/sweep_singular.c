/* Where a sweep comes nearest to gaining a mobility: minima of the smallest singular value. */
#include "analysis/singular.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>

static const km_substructure *moving(const km_sweeper *r) {
  return &r->m->substructures[r->substructure];
}

/* Value `index` (from 1) at the state's pose. */
static double value_at(km_singular_watch *w, const km_sweeper *r, int index) {
  int count;
  const double *values = km_singular_values(w->singular, r->m, r->s, moving(r), &count);
  return index > 0 && index <= count ? values[index - 1] : nan("");
}

double km_singular_kept(km_singular_watch *w, const km_sweeper *r) {
  if (r->substructure < 0 || !km_singular_fits(moving(r)))
    return nan("");
  return value_at(w, r, r->s->partition[r->substructure].rank);
}

typedef struct search {
  km_singular_watch *watch;
  km_sweeper *sweeper;
} search;

static double probe(double s, void *context) {
  search *x = context;
  km_sweeper *r = x->sweeper;
  return r->mover.probe(r->mover.self, s, r->rates) ? value_at(x->watch, r, x->watch->generic) : (double)NAN;
}

/* The minimum that the middle one of the last three rows brackets, by Brent's method. Where a pose between them can't
 * be reached in one go, that row itself. */
static km_extreme locate(km_singular_watch *w, km_sweeper *r) {
  search x = {w, r};
  gsl_function f = {probe, &x};
  km_extreme best = {w->value[1], w->s[1]};
  bool up = w->s[0] > w->s[2];
  gsl_min_fminimizer *minimiser = gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent);
  if (!minimiser)
    return best;
  int status = gsl_min_fminimizer_set_with_values(minimiser, &f, w->s[1], w->value[1], w->s[up ? 2 : 0],
                                                  w->value[up ? 2 : 0], w->s[up ? 0 : 2], w->value[up ? 0 : 2]);
  for (int i = 0; i < 100 && !status; ++i) {
    status = gsl_min_fminimizer_iterate(minimiser);
    double low = gsl_min_fminimizer_x_lower(minimiser), high = gsl_min_fminimizer_x_upper(minimiser);
    if (!status)
      best = (km_extreme){gsl_min_fminimizer_f_minimum(minimiser), gsl_min_fminimizer_x_minimum(minimiser)};
    if (high - low <= 1e-10 * (fabs(low) + fabs(high)) || best.number < 1e-12)
      break;
  }
  gsl_min_fminimizer_free(minimiser);
  r->mover.settle(r->mover.self, w->s[0]);
  return best;
}

static bool add_minimum(km_mobility_sweep *out, km_extreme minimum) {
  void *minima = out->minima;
  if (!km_reserve(&minima, &out->minimum_capacity, out->minimum_count + 1, sizeof minimum))
    return false;
  out->minima = minima;
  out->minima[out->minimum_count++] = minimum;
  return true;
}

static void take_smaller(km_extreme *smallest, km_extreme found) {
  if (found.number < smallest->number || isnan(smallest->number))
    *smallest = found;
}

km_status km_singular_see(km_singular_watch *w, km_sweeper *r, double s, km_mobility_sweep *out, km_error *error) {
  if (!w->singular || r->substructure < 0)
    return KM_OK;
  if (!km_singular_fits(moving(r)))
    return km_fail(error, KM_USAGE, "singular values of substructure %d, which has %d coordinates; expected at most %d",
                   r->substructure + 1, moving(r)->columns, KM_MOST_SINGULAR);
  int rank = r->s->partition[r->substructure].rank;
  if (rank > w->generic) { /* values of different places in the order can't be compared */
    w->generic = rank;
    w->rows = 0;
  }
  for (int i = 2; i > 0; --i) {
    w->s[i] = w->s[i - 1];
    w->value[i] = w->value[i - 1];
  }
  w->s[0] = s;
  w->value[0] = value_at(w, r, w->generic);
  w->rows++;
  take_smaller(&out->smallest, (km_extreme){w->value[0], s});
  if (w->rows < 3 || !(w->value[1] < w->value[0] && w->value[1] < w->value[2]))
    return KM_OK;
  km_extreme minimum = locate(w, r);
  take_smaller(&out->smallest, minimum);
  return add_minimum(out, minimum) ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the singular values");
}
