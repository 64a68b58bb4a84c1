/* Singular values of a substructure's Jacobian, for reports: they cost a hundred times what the partition does. Private
 * to analysis/. */
#ifndef KM_MOBILITY_JACOBIAN_SINGULAR_VALUES_H
#define KM_MOBILITY_JACOBIAN_SINGULAR_VALUES_H

#include "kinematics/state.h"
#include "kmech/mobility.h"

/* Workspace for matrices of some size. */
typedef struct km_svd_workspace {
  double *A, *V, *work; /* A: the matrix or its transpose, whichever is tall, by rows */
} km_svd_workspace;
bool km_svd_reserve(km_svd_workspace *room, int rows, int columns, km_arena *arena);
/* The singular values of J[rows × columns, column-major] in falling order, into values[min(rows, columns)]; returns how
 * many. None is called 0 here: which of them count as 0 is for km_rank_evidence_find to say (lib/README.md, tolerances:
 * a rank is doubtful). O(rows · columns · min). */
int km_svd_values(const double *J, int rows, int columns, km_svd_workspace *room, double *values);

typedef struct km_singular_value_workspace km_singular_value_workspace;

/* Workspace for any substructure of up to KM_MAX_SINGULAR rows and columns. NULL when out of memory. */
km_singular_value_workspace *km_singular_value_workspace_create(const km_mechanism *mechanism);
bool km_singular_values_fit(const km_substructure *sub);
void km_singular_value_workspace_free(km_singular_value_workspace *singular);

/* The singular values of J D⁻¹ in falling order, D as in theory 4 (rows: lengths over the substructure's size, each
 * loop about a point of its own), at the state's Jacobian. Borrowed, until the next call; *count of them. O(n³). */
const double *km_singular_values(km_singular_value_workspace *singular, const km_mechanism *mechanism,
                                 const km_state *state, const km_substructure *sub, int *count);

#endif
