/* Surface of closed configurations with two drivers (docs/theory.md 4.19).
 *
 *   e(q) = 0 [r],   J = (A B),   A: the r columns of the other coordinates, B: those of the two drivers
 *
 * Coordinates are scaled: angles in radians, lengths over the substructure's size. */
#ifndef KM_SPACE_DRIVER_SURFACE_H
#define KM_SPACE_DRIVER_SURFACE_H

#include "kinematics/state.h"
#include "kmech/space.h"

typedef struct km_driver_surface {
  const km_mechanism *m;
  km_state *s;
  const km_substructure *sub;
  int columns, rows; /* rows = columns − 2 */
  int driver[2];     /* columns of the drivers */
  int *other;        /* [rows] the other columns */
  double *J;         /* [rows × columns], column-major */
  double *A;         /* [rows × rows], by rows: factors after km_driver_surface_factor */
  int *row;
  double *step, *x, *b; /* [columns], [rows], [rows] */
} km_driver_surface;

/* Updates e and J at the state's configuration. */
void km_driver_surface_update(km_driver_surface *f);
/* Factors A of the last update; *sign is that of det A. False at a singular configuration. */
bool km_driver_surface_factor(km_driver_surface *f, int *sign);

/* Follows the singularity curves, on which A z = 0, from configurations near them. */
typedef struct km_singularity_curves km_singularity_curves;
km_singularity_curves *km_singularity_curves_create(km_driver_surface *surface, const km_space_map_def *def,
                                                    km_table *table);
void km_singularity_curves_free(km_singularity_curves *curves);
/* Adds the curve nearest to the saved configuration, unless it is in the table. `reach`: largest distance of the
 * curve. False when out of memory. */
bool km_singularity_curves_add(km_singularity_curves *curves, const double *saved, double reach);
int km_singularity_curves_count(const km_singularity_curves *curves);

#endif
