/* Redundant constraints over a whole sweep: which stay, and where there are more. */
#ifndef KMECH_SWEEP_REDUNDANCY_H
#define KMECH_SWEEP_REDUNDANCY_H

#include "kmech/redundancy.h"
#include "kmech/sweep_plan.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A pose of the sweep with more redundant constraints than the others, and as much more mobility. */
typedef struct km_extra_redundancy {
  double s; /* where: the driver, or arc length */
  int more; /* how many more redundant constraints */
} km_extra_redundancy;

/* What is constrained twice along a sweep. */
typedef struct km_sweep_redundancies {
  km_redundancies lasting;    /* if asked for: named at a pose of the least mobility, redundant at every pose */
  km_extra_redundancy *extra; /* rows and branch points, by s in the order of the sweep */
  size_t extra_count;
} km_sweep_redundancies;

/* From the rows of a sweep: the rank of each pose says how many constraints are redundant there (6 · loops + couplings
 * − rank). `named`: the lasting ones are named too, on a state of its own. Free `*out` in any case. */
KM_API km_status km_sweep_redundancies_find(const km_mechanism *mechanism, const km_sweep *sweep, bool named,
                                            km_sweep_redundancies *out, km_error *error);
KM_API void km_sweep_redundancies_free(km_sweep_redundancies *redundancies);

#ifdef __cplusplus
}
#endif
#endif
