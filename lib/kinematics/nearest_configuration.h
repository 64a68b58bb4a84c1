/* The closed pose that is closest to a given one. Private to kinematics/. */
#ifndef KM_KINEMATICS_NEAREST_CONFIGURATION_H
#define KM_KINEMATICS_NEAREST_CONFIGURATION_H

#include "kinematics/state.h"

/* Newton's method on the conditions for the least |D (x − y)| with closed loops, whose matrix is sparse:
 * [D² − Σ λ_r ∂²e_r, −Jᵀ; J, 0]. Least steps leave out how the loops bend, and part from the closest pose where its distance
 * passes the radius of their bend; these don't. */
typedef struct km_nearest_configuration {
  int size;                                 /* columns and rows of J: of the matrix */
  int *start, *row;                         /* its pattern, by columns */
  double *value;                            /* [start[size]] */
  int hessian_count;                        /* of km_loops_hessian_entries */
  int *hessian_index;                       /* [2 · pairs] where both entries of each are in `value`; */
  int *J_index, *transposed_index;          /* [pattern.size] the same of J, and of −Jᵀ; */
  int *diagonal_index;                      /* [size] and of the diagonal */
  double *hessian, *hessian_diagonal;       /* [pairs], [columns] of km_loops_hessian */
  double *b, *x;                            /* [size] right side; the step, and behind it λ */
  double *residual, *correction;            /* [size] of a solution by the factor of a matrix before */
  double *displacement, *next_displacement; /* [columns] for the caller */
  bool *fixed;                              /* [size] coordinates that don't move, rows that aren't primary; */
  bool *fixed_next;                         /* [size] and room for those of the next pose */
  km_partition factor;                      /* of the matrix, or of one before it with the same coordinates and rows */
  bool is_factored;                         /* is there one? */
  bool is_current;                          /* is it of the matrix as it is now? */
  bool is_costly;                           /* does it take longer than corrections of solutions by one before? */
} km_nearest_configuration;

/* For a substructure, whose mechanism has no ball joints: two turns about different axes have no difference. False when out of
 * memory. O(entries of J and pairs of columns in a loop). */
bool km_nearest_configuration_reserve(km_nearest_configuration *closest, const km_mechanism *mechanism,
                                      const km_substructure *sub, km_arena *arena);

/* From the state's pose, which is `away` (scaled) from y, to the closed pose closest to y; `away` is then what leads from y
 * there. The coordinate of `driver` (a column, or KM_NO_DRIVER) doesn't move, and `pivots` tells the primary rows. False where
 * Newton's method gives out. Leaves the state at its last pose. */
bool km_nearest_configuration_find(km_nearest_configuration *closest, const km_mechanism *mechanism, km_state *state,
                                   int substructure, int driver, const km_partition *pivots, double *away);
/* How the closest pose found last moves where y moves by `step`, which is then that. */
void km_nearest_configuration_follow(km_nearest_configuration *closest, const km_mechanism *mechanism,
                                     const km_substructure *sub, double *step);

#endif
