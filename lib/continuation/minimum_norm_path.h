/* Path of least motion (theory 4.7): with more freedoms than the driver's,
 *
 *   dq/ds = t(q),   t_driver = 1,  J t = 0,  |D t| minimal
 *
 * Predictors: variable-step Adams-Bashforth, Runge-Kutta 5(4), implicit backward difference. Each returns the ratio of
 * its error to the allowed one, km_path_allowed |move|_inf + km_path_rounding: above 1 the step is too long. Private to
 * continuation/. */
#ifndef KM_CONTINUATION_MINIMUM_NORM_PATH_H
#define KM_CONTINUATION_MINIMUM_NORM_PATH_H

#include "continuation/predictor_corrector.h"
#include "kinematics/nearest_configuration.h"

enum { KM_PATH_STAGES = 6, KM_PATH_NODES = KM_OLDER_STEPS + 2, KM_PATH_LEAST_NODES = 4 };

#define T        double
#define FN(name) km_##name
#include "continuation/multistep_body.h"
#undef T
#undef FN

/* Allowed error relative to |move|, and the rounding of a step (scaled). The end of a sweep is promised to 1e-4 for
 * any division of the range; neighbouring paths of least motion can diverge a thousandfold on the way. */
static const double km_path_allowed = 1e-7, km_path_rounding = 1e-13;
/* Coefficients of the Runge-Kutta method 5(4) of J. R. Cash and A. H. Karp, 1990: stages, fifth and fourth order. */
extern const double km_path_stage_weights[KM_PATH_STAGES][KM_PATH_STAGES - 1], km_path_fifth[KM_PATH_STAGES],
    km_path_fourth[KM_PATH_STAGES];

typedef struct km_minimum_norm_path {
  double *rate[KM_PATH_STAGES]; /* [columns] t at the stages */
} km_minimum_norm_path;

/* False without memory. */
bool km_minimum_norm_path_reserve(km_minimum_norm_path *path, int columns, km_arena *arena);

/* Predicts a step h from the saved configuration with tangent t by Runge-Kutta 5(4); all stages use the given pivots.
 * The error estimate is the difference of both orders. The state stays displaced as by km_state_move_aside, with
 * these pivots. */
double km_minimum_norm_path_predict_runge_kutta(km_minimum_norm_path *path, const km_mechanism *mechanism,
                                                km_state *state, int substructure, int driver, const km_factor *pivots,
                                                const double *saved, const double *t, double h, double *move);
/* Predicts the step by variable-step Adams-Bashforth: the integral of the polynomial through the last 4 or 5
 * tangents. The error estimate is the difference to one tangent less. HUGE_VAL with fewer than four tangents. The
 * state does not move. */
double km_minimum_norm_path_predict_multistep(const km_mechanism *mechanism, const km_substructure *sub,
                                              const km_step_history *history, double h, double *move);
/* Predicts the step by the second-order backward difference (C. Gear), for stiff fields: the closed configuration
 * closest, in D, to q + h² / (h_last (h_last + 2 h)) last_move; for a first step closest to q (implicit Euler). The
 * error estimate is a part of the difference to the extrapolated curve. HUGE_VAL if Newton's method fails. The state
 * stays displaced. Not for ball joints. */
double km_minimum_norm_path_predict_implicit(km_nearest_configuration *closest, const km_mechanism *mechanism,
                                             km_state *state, int substructure, int driver,
                                             const km_step_history *history, double h, double *move);

#endif
