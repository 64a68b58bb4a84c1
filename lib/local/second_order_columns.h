/* Second-order conditions of a substructure with many freedoms, by columns instead of a basis (docs/theory.md 5.5). */
#ifndef KM_LOCAL_SECOND_ORDER_COLUMNS_H
#define KM_LOCAL_SECOND_ORDER_COLUMNS_H

#include "kinematics/state.h"
#include "linalg/sparse/sparse_qr.h"

/* Condition i on a direction x with J x = 0, |D x| = 1 is w_iᵀγ(x) = 0. Left null vectors w_i of unit length are stored
 * by their entries. γ is quadratic with derivatives in the pattern of J, so nothing of size freedom² is formed. */
typedef struct km_second_order_columns {
  const km_mechanism *m;
  km_state *s;
  const km_substructure *sub;
  double residual;         /* residual of the configuration */
  int rank, *primary;      /* [rank] primary rows of J */
  int *row_start, *column; /* [rows + 2] entries of J by row: their columns, ascending, */
  int *value_index;        /* and the indices of their values in J */
  int conditions;
  int *w_start, *w_row;      /* rows of each w_i, */
  double *w;                 /* and its entries */
  int *g_start, *g_column;   /* columns on which each condition depends, ascending */
  double *J;                 /* [pattern.size] Jacobian of the configuration */
  double *gamma_derivatives; /* [pattern.size] ∂γ/∂x */
  double *gamma;             /* [rows] */
  double *rate;              /* [coordinate] */
  double *value, *g;         /* values of the conditions; their gradients over the weights, by g_start */
  double *sum;               /* [columns] accumulator, 0 between conditions */
  double *b, *z;             /* right side and solution of a step */
  double size;               /* scale of the conditions */
  km_sparse_qr *q;
} km_second_order_columns;

/* Creates the conditions at the state's configuration, after km_loops_update, with the rank tolerance `tolerance`.
 * KM_MEMORY; KM_IO: SPQR is not installed. Free it in any case. O(entries of the sparse factors). */
km_status km_second_order_columns_create(const km_mechanism *mechanism, km_state *state, int substructure,
                                         double tolerance, km_arena *arena, km_second_order_columns *out,
                                         km_error *error);
void km_second_order_columns_free(km_second_order_columns *conditions);

/* True if the unit direction x, with J x = 0, violates a condition far beyond rounding. The state is at the same
 * configuration. */
bool km_second_order_columns_refutes(km_second_order_columns *conditions, const double *x);

/* Finds a unit direction near x, with J x = 0, that satisfies all conditions, by damped Gauss-Newton with minimum-norm
 * steps |D δx|. False if there is none, or out of memory. The state is at the same configuration. Up to 60 sparse QR
 * factorisations. */
bool km_second_order_columns_solve(km_second_order_columns *conditions, double *x);

#endif
