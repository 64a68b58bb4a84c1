/* Singularity curves det K = 0 of a surface with two controls (docs/theory.md 4.19, 4.20).
 *
 *   R(q, z) = (e(q); K(q) z; cᵀ z − 1) = 0,   K of the surface (driver_surface.h) */
#ifndef KM_SPACE_SINGULARITY_CURVES_H
#define KM_SPACE_SINGULARITY_CURVES_H

#include "space/driver_surface.h"

typedef struct km_singularity_curves km_singularity_curves;

/* The table has the columns curve; kind, or with a number of the design number and critical; q. of all coordinates;
 * with an output the x y z of its point. NULL when out of memory. */
km_singularity_curves *km_singularity_curves_create(km_driver_surface *surface, km_table *table);
void km_singularity_curves_free(km_singularity_curves *curves);
/* Adds the curve of this kind nearest to the saved configuration, unless it is in the table. `reach`: largest distance
 * of the curve. False when out of memory. */
bool km_singularity_curves_add(km_singularity_curves *curves, km_singularity_kind kind, const double *saved,
                               double reach);
/* Moves the surface from point i of a curve of the drivers to its side, by `distance` along z; the loops are then open.
 * False for another kind of curve. *is_point: there is a point i. */
bool km_singularity_curves_leave(km_singularity_curves *curves, size_t i, double distance, bool *is_point);
int km_singularity_curves_count(const km_singularity_curves *curves);

/* Critical points of the curves: extrema of the number. Borrowed. */
const km_turning_point *km_singularity_curves_critical(const km_singularity_curves *curves, int *count);

#endif
