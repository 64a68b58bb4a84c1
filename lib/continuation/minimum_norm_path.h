/* The path of least motion, where more freedoms are left than the driver's. Private to kinematics/. */
#ifndef KM_CONTINUATION_MINIMUM_NORM_PATH_H
#define KM_CONTINUATION_MINIMUM_NORM_PATH_H

#include "continuation/predictor_corrector.h"
#include "kinematics/nearest_configuration.h"

enum { KM_PATH_STAGES = 6, KM_PATH_NODES = KM_OLDER_STEPS + 2, KM_PATH_LEAST_NODES = 4 };

/* Error that is allowed, of the length of a step. The contract promises 1e-4 at the end of a sweep however it is cut: paths of
 * least motion may part by a thousandfold on the way. And the rounding of a step, scaled. */
static const double km_path_allowed = 1e-7, km_path_grain = 1e-13;
/* Below this angle the rate of a rotation vector is found by a series. */
#define KM_PATH_NEAR 1e-2
/* J. R. Cash and A. H. Karp, A variable order Runge-Kutta method, 1990. */
extern const double km_path_stage_shares[KM_PATH_STAGES][KM_PATH_STAGES - 1], km_path_fifth[KM_PATH_STAGES],
    km_path_fourth[KM_PATH_STAGES];

typedef struct km_minimum_norm_path {
  double *rate[KM_PATH_STAGES]; /* [columns] t at the stages */
} km_minimum_norm_path;

/* False when out of memory. */
bool km_minimum_norm_path_reserve(km_minimum_norm_path *path, int columns, km_arena *arena);

/* The move along t = dq/ds (driver's entry 1, the others least) from the saved pose, where t is known, to s + h: a step
 * of Runge-Kutta's fifth order, whose stages use the pivots of the pose. Returns what the fourth order says otherwise,
 * over the length of the move and the error that is allowed: above 1 the step is too long. Leaves the state off the
 * pose as km_state_move_temporarily does, with the pivots of the pose. */
double km_minimum_norm_path_predict(km_minimum_norm_path *path, const km_mechanism *mechanism, km_state *state,
                                    int substructure, int driver, const km_partition *pivots, const double *saved,
                                    const double *t, double h, double *move);
/* The same by the tangents of the poses before, which takes no stages: the polynomial through them, as Adams and Bashforth
 * have it, wherever the poses are. Returns what it says otherwise with one tangent less, likewise; HUGE_VAL where there are
 * less than four. The state stays where it is. */
double km_minimum_norm_path_continue(const km_mechanism *mechanism, const km_substructure *sub,
                                     const km_step_history *course, double h, double *move);
/* The same where the field is stiff: poses beside the path come back to it within far less than h, and steps of the others would
 * have to be as short as that. The closed pose closest to where the last two poses lead: C. Gear's second-order step backward
 * for q̇ at right angles, in D, to all motions that leave the driver alone; of a first step the pose closest to the last one,
 * Euler's. Returns what it differs by from the curve through these poses and the tangent, likewise; HUGE_VAL where Newton's
 * method gives out. Leaves the state off the pose. Not for ball joints. */
double km_minimum_norm_path_record(km_nearest_configuration *closest, const km_mechanism *mechanism, km_state *state,
                                   int substructure, int driver, const km_step_history *course, double h, double *move);

#endif
