/* The equations of a curve on a surface of configurations (docs/theory.md 4.19).
 *
 *   singular: R(q, z) = (e(q); K(q) z; cᵀ z − 1) = 0,   c = z at the last point; one unknown more than equations
 *             M = dR = (J 0; (dK/dq) z K; 0 cᵀ),   dK/dq by central differences, and so the number's column of J
 *   limit   : R(q) = (e(q); q_k − bound) = 0,   M = (J; unit row k);   clearance: d(q) − d_least, its gradient
 *   M t = 0, |t| = 1;   predictor (q, z) + h t;   corrector: Newton's method with tᵀ x = 0, the last row of M
 *
 * The augmented system is regular at folds, where K alone is singular (A. Griewank, G. W. Reddien 1984). */
#ifndef KM_SPACE_CURVE_SYSTEM_H
#define KM_SPACE_CURVE_SYSTEM_H

#include "space/curves/surface_curves.h"

typedef struct km_curve_system {
  km_driver_surface *f;
  int order;                 /* order of K */
  km_surface_curve of;       /* the present curve */
  int vector;                /* length of z: order, 0 of a limit */
  int unknowns;              /* columns + vector */
  double determinant;        /* det M at the last tangent */
  double *M, *R, *x, *c;     /* [unknowns²], [unknowns], [unknowns], [order] */
  double *K, *forward;       /* [order²] K, and K of a forward difference */
  double *e, *number_column; /* [rows] e of a forward difference, ∂e by the number */
  double *z, *t;             /* null vector and tangent of the present configuration */
  int *row;
} km_curve_system;

/* Allocates for curves of any kind. False when out of memory. */
bool km_curve_system_create(km_curve_system *system, km_driver_surface *surface, km_arena *arena);
/* Chooses the curve. */
void km_curve_system_choose(km_curve_system *system, const km_surface_curve *of);
/* Computes t at the present point, in the sense of the last one. False at a singular point. */
bool km_curve_system_update_tangent(km_curve_system *system);
/* Moves by h along t and corrects; *first: the first correction. False: the curve isn't met. */
bool km_curve_system_step(km_curve_system *system, double h, double *first);
/* z: unit vector of the smallest singular value of K at the state's configuration. */
bool km_curve_system_start_vector(km_curve_system *system);
/* Moves the state to the nearest point of the curve by minimum-norm steps, Newton's method with the last row of M in
 * its null space, and computes t. */
bool km_curve_system_enter(km_curve_system *system);

#endif
