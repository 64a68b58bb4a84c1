/* Closing the loops of a substructure by Newton-Raphson (theory 4). */
#ifndef KM_KINEMATICS_LOOP_CLOSING_H
#define KM_KINEMATICS_LOOP_CLOSING_H

#include "kinematics/state.h"

static const double km_residual_tolerance = 1e-12; /* rms of the primary rows (theory 4) */
static const double km_step_tolerance =
    1e-9; /* a step below this shows that the pose is found, not just the error small */
/* The same of a predicted pose, whose error isn't the square of another one: near singular poses a small error can be far
 * away. */
static const double km_predicted_step_tolerance = 1e-12;
static const double km_max_newton_step = 0.6;       /* radians, or substructure sizes */
static const double km_pivot_reuse_residual = 0.05; /* residual below which the pivots of the last pose serve */

/* Coordinates of many turns carry their rounding into the loops: thresholds grow by this per radian or size of the
 * largest one, to so much at most. */
static const double km_tolerance_scale_growth = 1e-3, km_max_tolerance_scale = 1e3;
typedef enum km_closure_outcome {
  KM_CLOSED,
  KM_INCONSISTENT, /* the primary equations close, the others keep more than the closure tolerance */
  KM_OPEN          /* the iteration gave out */
} km_closure_outcome;

/* Evidence of one closure. */
typedef struct km_closure {
  int iterations;
  double residual;   /* rms loop error of the worst loop, scaled */
  int worst;         /* that loop; -1: a coupling */
  double correction; /* scaled length of all that Newton moved, |D δq| */
  const double
      *last_step; /* [columns] the step that was too small to be taken, in the state's `work`; of closed loops */
} km_closure;

/* Newton steps from the state's coordinates until the primary rows are below 1e-12 rms; each step has the least
 * |D δq|, and the coordinate of `driver` (a column, or KM_NO_DRIVER) doesn't move. Leaves error, Jacobian and
 * partition of the final pose; pivots are kept from call to call while the monitor allows it. */
km_closure_outcome km_loops_close(const km_mechanism *mechanism, km_state *state, int substructure, int driver,
                                  km_closure *evidence);

/* The same with the driver's coordinate held: where it can't be independent, so that the pose is rigid, the other
 * coordinates close what they can, and the rest is left in the residual. Beside a branch point rows depend on each other so
 * nearly that the rounding of closed loops alone moves Newton: the first step that isn't shorter than the one before it ends
 * that. Pivots are kept for the next such call only. */
km_closure_outcome km_close_with_driver(const km_mechanism *mechanism, km_state *state, int substructure, int driver,
                                        km_closure *evidence);

/* By km_loops_close or km_close_with_driver, with the rank that the closed pose has: on the way there pivots of an open pose may have left
 * out a row. Leaves pivots of the closed pose, searched anew. */
typedef km_closure_outcome (*km_closing_function)(const km_mechanism *mechanism, km_state *state, int substructure,
                                                  int driver, km_closure *evidence);
km_closure_outcome km_close_fully(km_closing_function close, const km_mechanism *mechanism, km_state *state,
                                  int substructure, int driver, km_closure *evidence);

/* The relative size below which a pivot counts as 0, with the secondary rows keeping `misfit` (scaled). */
double km_rank_tolerance(const km_mechanism *mechanism, const km_substructure *sub, double misfit);

/* Searches pivots at the state's Jacobian: forced `driver` column or none. */
void km_search_pivots(const km_mechanism *mechanism, km_state *state, int substructure, int driver, double tolerance);

/* The same at the pose that the state's coordinates have, with the tolerance that its misfit asks for. */
void km_update_and_search_pivots(const km_mechanism *mechanism, km_state *state, int substructure, int driver,
                                 double misfit);

/* The same where what follows takes steps alone: of many motions the independent columns needn't be good ones, see `unwatched` of a
 * partition. */
void km_search_pivots_for_steps(const km_mechanism *mechanism, km_state *state, int substructure, int driver,
                                double tolerance);

/* Has every row a pivot, so that no search further on finds more of them? Only where a search takes long that matters. */
static inline bool km_has_full_row_rank(const km_partition *p) {
  return p->sparse && p->rank == p->rows;
}

/* The pivots at hand on the state's Jacobian as far as steps need them: see km_partition_defer. False, and nothing happens, where
 * steps need more of them. */
bool km_defer_pivots(km_state *state, int substructure, int driver);

/* x −= D⁻¹ Z Zᵀ D x over the null directions that leave the driver alone: what remains is the least step with
 * the same effect on the constraints and the driver. */
void km_minimum_norm_step(const km_mechanism *mechanism, km_state *state, int substructure, int driver, double *x);

/* The rates t with J t = 0 and the driver's 1, least in |D t|, of a driver that is independent. */
void km_minimum_norm_rates(const km_mechanism *mechanism, km_state *state, int substructure, int driver, double *t);

/* (D a)·(D b) of two scaled steps. */
double km_step_dot(const km_mechanism *mechanism, const km_substructure *sub, const double *a, const double *b);
/* |D x| of a scaled step. */
double km_step_length(const km_mechanism *mechanism, const km_substructure *sub, const double *x);

#endif
