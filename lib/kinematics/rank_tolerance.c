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

/* True if the present pivots are those that this search would find. The sparse factor tests that itself
 * (km_sparse_has_factor). */
static bool is_search_current(const km_state *s, int index, int driver, double tolerance) {
  const km_partition *p = &s->partition[index];
  const km_cached_configuration *shown = &s->cached[index];
  return !p->sparse && !p->failed && shown->is_valid && shown->evaluation_at_search == shown->evaluations &&
         shown->partition_version == p->version && shown->driver == driver &&
         shown->forced_never_pivot == p->forced_never_pivot && shown->tolerance == tolerance;
}

/* Records the arguments of the last search for pivots. */
static void record_search(km_state *s, int index, int driver, double tolerance) {
  const km_partition *p = &s->partition[index];
  km_cached_configuration *shown = &s->cached[index];
  shown->evaluation_at_search = shown->evaluations;
  shown->partition_version = p->version;
  shown->driver = driver;
  shown->forced_never_pivot = p->forced_never_pivot;
  shown->tolerance = tolerance;
}

/* Factors the Jacobian with complete pivoting, unless an equal search is current. */
void km_search_pivots(const km_mechanism *m, km_state *s, int index, int driver, double tolerance) {
  const km_substructure *sub = &m->substructures[index];
  tolerance = km_larger(tolerance, s->partition[index].min_relative_pivot);
  if (is_search_current(s, index, driver, tolerance)) {
    s->pivot_driver[index] = driver;
    return;
  }
  s->partition[index].ties_by_position = driver >= 0;
  if (driver >= 0)
    s->forced[driver] = true;
  km_partition_factor(&s->partition[index], km_state_jacobian(s, sub), sub->rows, sub->columns,
                      driver >= 0 ? s->forced : NULL, tolerance);
  if (driver >= 0)
    s->forced[driver] = false;
  s->partition[index].ties_by_position = false;
  s->pivot_driver[index] = driver;
  record_search(s, index, driver, tolerance);
}

/* Evaluates the Jacobian at the present configuration and searches pivots. */
void km_update_and_search_pivots(const km_mechanism *m, km_state *s, int index, int driver, double misfit) {
  const km_substructure *sub = &m->substructures[index];
  km_loops_update(m, s, sub);
  km_search_pivots(m, s, index, driver, km_rank_tolerance(m, sub, misfit));
}

void km_search_pivots_for_steps(const km_mechanism *m, km_state *s, int index, int driver, double tolerance) {
  s->partition[index].accepts_any_basis = true;
  km_search_pivots(m, s, index, driver, tolerance);
  s->partition[index].accepts_any_basis = false;
}

bool km_refactor_for_steps(const km_mechanism *m, km_state *s, int index, bool is_full_pattern) {
  const double *J = km_state_jacobian(s, &m->substructures[index]);
  km_partition *p = &s->partition[index];
  p->accepts_any_basis = true;
  bool is_accepted = is_full_pattern ? km_partition_refactor_full_pattern(p, J) : km_partition_refactor(p, J);
  p->accepts_any_basis = false;
  return is_accepted;
}
