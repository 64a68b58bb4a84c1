/* Closed configuration that is nearest to a given one (docs/theory.md 4.8).
 *
 *   min |D (x − y)|²  subject to  e(x) = 0:     [D² − Σ λ_r ∂²e_r   −Jᵀ] [δ]   [−D² (x − y)]
 *                                               [J                   0 ] [λ] = [−e         ] */
#ifndef KM_KINEMATICS_NEAREST_CONFIGURATION_H
#define KM_KINEMATICS_NEAREST_CONFIGURATION_H

#include "kinematics/state.h"

/* Newton's method on the Karush-Kuhn-Tucker conditions; the matrix is sparse. Minimum-norm steps omit the Hessian of
 * the closure and drift away where the distance exceeds the radius of curvature. */
typedef struct km_nearest_configuration {
  int size;                                 /* columns + rows of J: order of the matrix */
  int *start, *row;                         /* pattern of the matrix, by columns */
  double *value;                            /* [start[size]] */
  int hessian_count;                        /* pairs of columns of km_loops_hessian_entries */
  int *hessian_index;                       /* [2 · hessian_count] indices of both entries of a pair in `value` */
  int *J_index, *transposed_index;          /* [pattern.size] indices of the entries of J, and of −Jᵀ, in `value` */
  int *diagonal_index;                      /* [size] indices of the diagonal entries in `value` */
  double *hessian, *hessian_diagonal;       /* [hessian_count], [columns] results of km_loops_hessian */
  double *b, *x;                            /* [size] right side; solution (δ, λ) */
  double *displacement, *next_displacement; /* [columns] for the caller: x − y, and its next value */
  bool *fixed;                              /* [size] fixed unknowns: driver, locked coordinates, multipliers of
                                             * secondary rows */
  km_factor *factor;                        /* factor of the matrix */
} km_nearest_configuration;

/* Reserves a solver for a substructure. Mechanisms with ball joints are excluded: two rotations about different axes
 * have no difference. False when out of memory. O(entries of J + pairs of columns on one side of a loop). */
bool km_nearest_configuration_reserve(km_nearest_configuration *closest, const km_mechanism *mechanism,
                                      const km_substructure *sub, km_arena *arena);

/* Moves the state to the closed configuration nearest to y. The state must be at y + displacement (scaled); on return
 * `displacement` is the step from y to the result. The coordinate of `driver` (a column, or KM_NO_DRIVER) is fixed;
 * `pivots` gives the primary rows. False if Newton's method does not converge; the state is left at its last
 * configuration. */
bool km_nearest_configuration_find(km_nearest_configuration *closest, const km_mechanism *mechanism, km_state *state,
                                   int substructure, int driver, const km_factor *pivots, double *displacement);
/* Linear response of the nearest configuration found last to a change of y: replaces `step` of y by the step of the
 * result. */
void km_nearest_configuration_follow(km_nearest_configuration *closest, const km_mechanism *mechanism,
                                     const km_substructure *sub, double *step);

#endif
