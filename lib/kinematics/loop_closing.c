/* Closes the loops of one substructure by Newton-Raphson with minimum-norm steps (docs/theory.md 4.2).
 *
 *   e(q)  = closure errors of all loops and couplings, stacked              [rows]
 *   J     = de/dq, factored as in linalg/factor.h; p = primary rows, Z = null space
 *   step  : J_p δ = −e_p,  |D δ| minimal,  δ_driver = 0;   q <- exp(δ) q,  |δ|_∞ limited to 0.6
 *
 * Converged : rms(e_p) <= σ_s 1e-12 and |δ|_∞ <= σ_s 1e-9 (1e-12 for a predicted configuration)
 * Consistent: residual of the worst loop <= max(closure tolerance, σ_s 1e-12), else KM_INCONSISTENT
 * Diverged  : a value that is not finite, or 60 iterations, whose steps of at most 0.6 end within 36 radians or sizes
 *
 * Pivots of the last configuration are reused below a residual of 0.05 while the growth monitor accepts them (3.3). */
#include "kinematics/loop_closing.h"
#include "base/number/tolerances.h"

#include "base/extrema.h"
#include "kinematics/loop_equations.h"

#include <string.h>

enum { MAX_ITERATIONS = 60 };

/* Root mean square of the errors of the primary rows. */
static double primary_rms(const km_factor *p, const double *error) {
  const int rank = km_factor_rank(p), *row = km_factor_row_order(p);
  double sum = 0.0;
  for (int i = 0; i < rank; ++i)
    sum += error[row[i]] * error[row[i]];
  return rank ? sqrt(sum / rank) : 0.0;
}

/* Factors J for a step: reuses the pivots near the solution while the growth monitor accepts them, else searches.
 * Minimum-norm steps do not depend on the basis of the null space. Pivots of a deficient rank that were found with the
 * loose tolerance of an open configuration can omit rows, so they are not reused. */
static void factor_step(const km_mechanism *m, km_state *s, int index, const km_pivoting *pivoting, double residual) {
  const km_substructure *sub = &m->substructures[index];
  if (residual < km_pivot_reuse_residual && s->pivot_driver[index] == pivoting->driver &&
      km_factor_refactor(s->factor[index], km_state_jacobian(s, sub), pivoting->basis))
    return;
  double tolerance = km_rank_tolerance(m, sub, residual);
  km_search_pivots_by(m, s, index, pivoting, tolerance);
  if (km_factor_rank(s->factor[index]) < sub->rows && tolerance > km_rank_tolerance(m, sub, 0.0))
    km_state_invalidate_pivots(s, index);
}

/* Newton step x = −J_p⁺ e_p in the metric D. Returns |x|_∞. */
static double newton_step(const km_mechanism *m, km_state *s, int index, int driver, double *x) {
  const km_substructure *sub = &m->substructures[index];
  double largest = 0.0;
  km_factor *p = s->factor[index];
  km_factor_minimum_norm(p, km_state_jacobian(s, sub), km_count_free_motions(p, driver), km_state_error(s, sub), x);
  for (int k = 0; k < sub->columns; ++k)
    x[k] = -x[k];
  if (driver >= 0) /* a dependent driver column has a step, which is discarded */
    x[driver] = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    largest = km_larger(fabs(x[k]), largest);
  return largest;
}

/* Tolerance scale of docs/theory.md 4.1: at most 1e3, since at 1e6 radians rounding is comparable with the geometry. A
 * ball joint is a unit quaternion and does not count. */
static double tolerance_scale(const km_mechanism *m, const km_state *s, const km_substructure *sub) {
  const int *coordinate = m->column_coordinate + sub->column_start;
  double largest = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    if (m->ball_of[coordinate[k]] < 0)
      largest = km_larger(fabs(s->q[coordinate[k]] / m->unit[coordinate[k]]), largest);
  return km_smaller(1.0 + largest / km_max_tolerance_scale(), km_max_tolerance_scale());
}

static km_closure_outcome closed_outcome(const km_mechanism *m, double residual, double scale) {
  return residual <= km_larger(m->closure_tolerance, scale * km_solved_rounding) ? KM_CLOSED : KM_INCONSISTENT;
}

/* State of Newton's iteration. */
typedef struct newton_state {
  double step, last;                         /* |δ|_∞ of this step, and of the last step from a converged residual */
  double residual_tolerance, step_tolerance; /* tolerances of the residual and of the step */
  bool is_residual_small;
} newton_state;

/* Convergence test; with a fixed driver also the first step that is not shorter than the last one. */
static bool is_converged(const km_pivoting *pivoting, const newton_state *n) {
  return n->is_residual_small && (n->step <= n->step_tolerance || (pivoting->driver_never_pivot && n->step >= n->last));
}

/* Newton-Raphson with minimum-norm steps; convergence, consistency and divergence tests as in the head of this file.
 */
static km_closure_outcome close_loops(const km_mechanism *m, km_state *s, int index, const km_pivoting *pivoting,
                                      km_closure *evidence) {
  const int driver = pivoting->driver;
  const km_substructure *sub = &m->substructures[index];
  const km_factor *p = s->factor[index];
  double *x = s->work, scale = tolerance_scale(m, s, sub);
  newton_state n = {.step = HUGE_VAL, .last = HUGE_VAL, .residual_tolerance = scale * km_solved_rounding};
  *evidence = (km_closure){.worst = -1, .last_step = x};
  for (int i = 0; i < MAX_ITERATIONS; ++i) {
    if (i == 0 && driver < 0)
      km_loops_update(m, s, sub);
    else
      km_loops_recompute(m, s, sub);
    evidence->iterations = i;
    evidence->residual = km_loops_worst(m, s, sub, &evidence->worst);
    if (!isfinite(evidence->residual))
      return KM_OPEN;
    n.step_tolerance = scale * (i == 0 && driver >= 0 ? km_solved_rounding : km_relative_zero);
    factor_step(m, s, index, pivoting, evidence->residual);
    n.step = newton_step(m, s, index, driver, x);
    n.is_residual_small = primary_rms(p, km_state_error(s, sub)) <= n.residual_tolerance;
    if (is_converged(pivoting, &n))
      return closed_outcome(m, evidence->residual, scale);
    n.last = n.is_residual_small ? n.step : HUGE_VAL;
    if (!isfinite(n.step))
      return KM_OPEN;
    if (n.step > km_max_newton_step)
      for (int k = 0; k < sub->columns; ++k)
        x[k] *= km_max_newton_step / n.step;
    if (i + 1 == MAX_ITERATIONS)
      break;
    evidence->correction += km_step_length(m, sub, x);
    km_state_move(m, s, sub, x);
  }
  /* Newton's method only halves its distance to a singular configuration: after all iterations a residual below the
   * tolerance is accepted. */
  return driver < 0 && primary_rms(p, km_state_error(s, sub)) <= n.residual_tolerance
             ? closed_outcome(m, evidence->residual, scale)
             : KM_OPEN;
}

/* Closes the loops; the final configuration is cached unless a driver is fixed. */
km_closure_outcome km_loops_close_by(const km_mechanism *m, km_state *s, int index, const km_pivoting *pivoting,
                                     km_closure *evidence) {
  km_pivoting of_steps = *pivoting;
  if (of_steps.basis == KM_BASIS_SHORT)
    of_steps.basis = KM_BASIS_ANY;
  km_closure_outcome outcome = close_loops(m, s, index, &of_steps, evidence);
  if (pivoting->driver < 0) /* configurations of a driven motion are not evaluated again */
    km_loops_cache(m, s, &m->substructures[index]);
  return outcome;
}

km_closure_outcome km_loops_close(const km_mechanism *m, km_state *s, int index, int driver, km_closure *evidence) {
  return km_loops_close_by(m, s, index, &(km_pivoting){.driver = driver}, evidence);
}

/* Full closing: repeats with pivots of the closed configuration until the rank no longer grows. */
km_closure_outcome km_loops_close_fully(const km_mechanism *m, km_state *s, int index, const km_pivoting *pivoting,
                                        km_closure *evidence) {
  enum { MAX_RANK_UPDATES = 4 };
  const km_substructure *sub = &m->substructures[index];
  km_state_invalidate_pivots(s, index);
  km_closure_outcome outcome = km_loops_close_by(m, s, index, pivoting, evidence);
  for (int i = 0; i < MAX_RANK_UPDATES && outcome == KM_CLOSED; ++i) {
    int rank = km_factor_rank(s->factor[index]);
    km_loops_update(m, s, sub);
    km_search_pivots_by(m, s, index, pivoting, km_rank_tolerance(m, sub, evidence->residual));
    if (km_factor_rank(s->factor[index]) <= rank)
      break;
    int iterations = evidence->iterations;
    outcome = km_loops_close_by(m, s, index, pivoting, evidence);
    evidence->iterations += iterations;
  }
  return outcome;
}
