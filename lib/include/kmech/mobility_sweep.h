/* Mobility numbers over the range of a driver. */
#ifndef KMECH_MOBILITY_SWEEP_H
#define KMECH_MOBILITY_SWEEP_H

#include "kmech/sweep_plan.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A pose at which a coordinate's mobility number passes through 0. */
typedef struct km_toggle {
  int coordinate; /* whose number is 0 there */
  double s;       /* of the driver, model's unit */
} km_toggle;

/* A smallest value along a sweep. */
typedef struct km_extreme {
  double number, s; /* a smallest value, and where */
} km_extreme;

/* The rows of a sweep with every mobility number, and what lies between the rows. */
typedef struct km_mobility_sweep {
  km_sweep motion;    /* its table has m. of every coordinate */
  km_toggle *toggles; /* in the order of the sweep */
  size_t toggle_count, toggle_capacity;
  km_extreme *extremes; /* [coordinate] smallest mobility numbers over the rows */
  km_extreme smallest;  /* singular value over the sweep; NaN unless the plan asks for singularities */
  km_extreme *minima;   /* of it along the sweep, located between the rows, in their order */
  size_t minimum_count, minimum_capacity;
} km_mobility_sweep;

/* Moves the assembled state from its pose to `from` without output, then gives steps + 1 rows. Where a part of
 * the range is out of reach the rows end (or begin) at the located bound and the status is KM_PARTIAL; start
 * and end say why. With one freedom the rows don't depend on `steps` (to 1e-8). With plan.singularities, the smallest
 * kept singular value of the moving substructure's J D⁻¹ (rows: lengths over its size, each loop about a point of its
 * own) is a column, and its minima are located; KM_USAGE above KM_MOST_SINGULAR coordinates. Free `*out` in any case.
 */
enum {
  KM_MOST_SINGULAR = 300 /* coordinates of which singular values are found along a sweep */
};
KM_API km_status km_mobility_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                       km_mobility_sweep *out, km_error *error);
KM_API void km_mobility_sweep_free(km_mobility_sweep *sweep);

#ifdef __cplusplus
}
#endif
#endif
