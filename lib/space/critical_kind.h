/* Kind of a critical value of a design's number (docs/theory.md 4.20).
 *
 *   wᵀ J = 0:  Q_ij = wᵀ D²e(n_i, n_j) on the null vectors n_1, n_2 of J
 *   det Q < 0: two curves of configurations cross;   det Q > 0: an isolated configuration
 *   rank J full: a cusp of the driver, at which two dead points meet */
#ifndef KM_SPACE_CRITICAL_KIND_H
#define KM_SPACE_CRITICAL_KIND_H

#include "space/driver_surface.h"

/* Finds the kind at the state's configuration, an extremum of the number on a singularity curve. False when out of
 * memory. */
bool km_critical_kind(km_driver_surface *surface, km_turning_kind *kind);

#endif
