/* Singular values of a substructure's Jacobian, for reports: they cost a hundred times as much as the partition.
 * Private to the library. */
#ifndef KM_MOBILITY_JACOBIAN_SINGULAR_VALUES_H
#define KM_MOBILITY_JACOBIAN_SINGULAR_VALUES_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

/* Workspace of km_svd_values. */
typedef struct km_svd_workspace {
  double *A, *V, *work; /* A: the matrix or its transpose, whichever is tall, row-major */
} km_svd_workspace;
bool km_svd_reserve(km_svd_workspace *workspace, int rows, int columns, km_arena *arena);
/* Computes the singular values of J[rows × columns, column-major] in descending order into values[min(rows,
 * columns)]; returns their number. km_rank_evidence_find decides which of them count as 0. O(rows · columns · min). */
int km_svd_values(const double *J, int rows, int columns, km_svd_workspace *workspace, double *values);

typedef struct km_singular_value_workspace km_singular_value_workspace;

/* Workspace for every substructure of up to KM_MAX_SINGULAR rows and columns. NULL without memory. */
km_singular_value_workspace *km_singular_value_workspace_create(const km_mechanism *mechanism);
bool km_singular_values_fit(const km_substructure *sub);
void km_singular_value_workspace_free(km_singular_value_workspace *singular);

/* Returns the singular values of J D⁻¹ in descending order (D: theory 1.4; lengths over the substructure's size, each
 * loop about its own point) at the state's Jacobian: *count of them, valid until the next call. O(n³). */
const double *km_singular_values(km_singular_value_workspace *singular, const km_mechanism *mechanism,
                                 const km_state *state, const km_substructure *sub, int *count);

#endif
