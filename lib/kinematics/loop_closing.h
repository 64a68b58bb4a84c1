/* Closes the loops of one substructure by Newton-Raphson with minimum-norm steps (docs/theory.md 4.2).
 *
 *   J_p δ = −e_p,   |D δ| minimal,   δ_driver = 0,   q <- exp(δ) q,   |δ|_∞ <= 0.6
 *
 * p: primary rows of the partition of J; e: closure errors; D: metric (1 for angles, 1/L for lengths). */
#ifndef KM_KINEMATICS_LOOP_CLOSING_H
#define KM_KINEMATICS_LOOP_CLOSING_H

#include "base/number/tolerances.h"
#include "kinematics/minimum_norm_step.h"
#include "kinematics/state.h"

/* Loops are closed if the rms of the primary rows e_p is at most σ_s km_solved_rounding and |δ|_∞ at most σ_s
 * km_relative_zero: a small residual alone is not convergence near singular configurations. |δ|_∞ of a predicted
 * configuration is at most σ_s km_solved_rounding, because its error is not the square of an earlier one
 * (docs/theory.md 4.2). */
static const double km_max_newton_step = 0.6;       /* radians, or substructure sizes */
static const double km_pivot_reuse_residual = 0.05; /* residual below which the pivots of the last configuration are
                                                     * reused */

/* Largest tolerance scale: σ_s = min(1 + max|q_j| / 1e3, 1e3), since coordinates of many turns carry their rounding
 * into the loops (docs/theory.md 4.1). With a larger one, open loops would count as closed. */
static inline double km_max_tolerance_scale(void) {
  return km_relative_zero / km_solved_rounding;
}
/* Largest correction over a predicted step, |D correction| / |D move|: a larger one can lead to another branch. The
 * strict one is for steps by arc length, from a branch point or over a singular configuration, where another branch is
 * near. */
static const double km_correction_ratio = 0.25, km_strict_correction_ratio = 0.05;

typedef enum km_closure_outcome {
  KM_CLOSED,
  KM_INCONSISTENT, /* primary rows close, secondary rows keep more than the closure tolerance */
  KM_OPEN          /* the iteration diverged or did not converge */
} km_closure_outcome;

/* Evidence of one closure. */
typedef struct km_closure {
  int iterations;
  double residual;   /* √(eᵀe/6) of the worst loop, scaled */
  int worst;         /* that loop; -1: a coupling */
  double correction; /* sum of the step lengths |D δ| */
  const double
      *last_step; /* [columns] the last Newton step, which was not applied since it is below the tolerance; in the
                   * state's `work`; closed loops only */
} km_closure;

/* Options of a search for pivots. */
typedef struct km_pivoting {
  int driver;                /* forced column, which is fixed in closing; KM_NO_DRIVER: none */
  bool driver_never_pivot;   /* the driver stays independent at any remaining rank */
  km_factor_basis basis;     /* use of the null space; minimum-norm steps themselves need any basis only */
  double min_relative_pivot; /* relative pivot below which no search goes, over the largest entry */
} km_pivoting;

/* Closes the loops from the state's coordinates by minimum-norm Newton steps; the coordinate of `driver` (a column, or
 * KM_NO_DRIVER) is fixed. Leaves errors, Jacobian and factor of the final configuration. Pivots are reused from call
 * to call while the growth monitor accepts them (docs/theory.md 3.3). */
km_closure_outcome km_loops_close(const km_mechanism *mechanism, km_state *state, int substructure, int driver,
                                  km_closure *evidence);
/* As km_loops_close. With driver_never_pivot, if the driver cannot be independent, the other coordinates reduce the
 * error and the rest stays in the residual. Rows are nearly dependent close to a branch point, where rounding keeps
 * Newton's method moving: the iteration ends at the first step that is not shorter than the one before it. */
km_closure_outcome km_loops_close_by(const km_mechanism *mechanism, km_state *state, int substructure,
                                     const km_pivoting *pivoting, km_closure *evidence);
/* Full closing (docs/theory.md 4.2): repeats with pivots of the closed configuration until the rank no longer grows,
 * since pivots of an open configuration can omit a row. Leaves pivots of a new search. */
km_closure_outcome km_loops_close_fully(const km_mechanism *mechanism, km_state *state, int substructure,
                                        const km_pivoting *pivoting, km_closure *evidence);

/* Rank tolerance: relative size below which a pivot counts as 0, if secondary rows keep `misfit` (scaled;
 * docs/theory.md 3.2). */
double km_rank_tolerance(const km_mechanism *mechanism, const km_substructure *sub, double misfit);

/* Factors the state's Jacobian with a search for pivots. `driver`: forced column, or KM_NO_DRIVER. */
void km_search_pivots(const km_mechanism *mechanism, km_state *state, int substructure, int driver, double tolerance);
void km_search_pivots_by(const km_mechanism *mechanism, km_state *state, int substructure, const km_pivoting *pivoting,
                         double tolerance);
/* As km_search_pivots without a driver, for the rank and minimum-norm steps: a sparse factor with many freedoms does
 * not optimise its independent columns, which takes longer than the elimination. */
void km_search_rank(const km_mechanism *mechanism, km_state *state, int substructure, double tolerance);

/* Updates errors and Jacobian at the state's coordinates and searches pivots with the rank tolerance of `misfit`. */
void km_update_and_search_pivots(const km_mechanism *mechanism, km_state *state, int substructure, int driver,
                                 double misfit);

#endif
