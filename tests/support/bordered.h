/* Static balance as one system of equations, for LAPACK: what laws and benchmarks compare with. */
#ifndef KM_TESTS_BORDERED_H
#define KM_TESTS_BORDERED_H

#include "forces/forces.h"

/* Six equations a body, one a coordinate; unknown are the reactions in the joints' axes and about the points that they
 * are reported at, then the couplings' multipliers. Column-major, rows × columns. */
typedef struct bordered {
  int rows, columns;
  double *A, *rhs; /* rhs: [the larger of rows, columns] */
} bordered;

/* Residue of equilibrium at the state's poses (km_poses_compute) and last forces; held[coordinate] of actuators or
 * f̄; moments over the length `reach`. */
bordered bordered_make(const km_mechanism *mechanism, const km_state *state, const km_forces *forces,
                       const double *held, double reach);
void bordered_free(bordered *system);

/* The wrench applied to a body, about the inertial origin. */
km_wrench applied_to(const km_forces *forces, int body);

#endif
