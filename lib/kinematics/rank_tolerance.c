/* Rank tolerance of a substructure's Jacobian, and the search for its pivots (docs/theory.md 3.2). */
#include "base/extrema.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"

/* min(0.05, max(1e-9 size, 10 misfit, 10 closure tolerance if stated)). */
double km_rank_tolerance(const km_mechanism *m, const km_substructure *sub, double misfit) {
  int size = sub->rows > sub->columns ? sub->rows : sub->columns;
  double tolerance = 1e-9 * fmax(size, 1.0);
  /* A misfit e of the data can produce a pivot of a few e. */
  if (m->closure_tolerance_given)
    tolerance = fmax(tolerance, 10.0 * m->closure_tolerance);
  return fmin(fmax(tolerance, 10.0 * misfit), 0.05);
}

/* Factors the Jacobian with complete pivoting. Near-ties of driven motions are ordered by position, so that designs
 * share pivots. */
void km_search_pivots_by(const km_mechanism *m, km_state *s, int index, const km_pivoting *pivoting, double tolerance) {
  const km_substructure *sub = &m->substructures[index];
  const bool has_driver = pivoting->driver >= 0;
  const km_factor_options options = {.tolerance = km_larger(tolerance, pivoting->min_relative_pivot),
                                     .forced = has_driver ? s->forced : NULL,
                                     .locked = km_state_locked_columns(s, index),
                                     .forced_never_pivot = pivoting->driver_never_pivot,
                                     .ties_by_position = has_driver,
                                     .basis = pivoting->basis};
  if (has_driver)
    s->forced[pivoting->driver] = true;
  km_factor_compute(s->factor[index], km_state_jacobian(s, sub), sub->rows, sub->columns, &options);
  if (has_driver)
    s->forced[pivoting->driver] = false;
  s->pivot_driver[index] = pivoting->driver;
}

void km_search_pivots(const km_mechanism *m, km_state *s, int index, int driver, double tolerance) {
  km_search_pivots_by(m, s, index, &(km_pivoting){.driver = driver}, tolerance);
}

void km_search_rank(const km_mechanism *m, km_state *s, int index, double tolerance) {
  km_search_pivots_by(m, s, index, &(km_pivoting){.driver = KM_NO_DRIVER, .basis = KM_BASIS_ANY}, tolerance);
}

/* Evaluates the Jacobian at the present configuration and searches pivots. */
void km_update_and_search_pivots(const km_mechanism *m, km_state *s, int index, int driver, double misfit) {
  const km_substructure *sub = &m->substructures[index];
  km_loops_update(m, s, sub);
  km_search_pivots(m, s, index, driver, km_rank_tolerance(m, sub, misfit));
}
