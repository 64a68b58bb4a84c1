/* The second-order conditions of a substructure with many freedoms, without a basis of these. Private to kinematics/ and
 * analysis/. */
#ifndef KM_LOCAL_SECOND_ORDER_COLUMNS_H
#define KM_LOCAL_SECOND_ORDER_COLUMNS_H

#include "kinematics/state.h"
#include "linalg/sparse/sparse_qr.h"

/* Condition i on a direction x with J x = 0 is w_iᵀγ(x) = 0, w_i the left null vectors of J, each a unit vector that is kept by
 * its entries: γ = −J̇ q̇ is linear in J's pattern, so nothing of the size freedom² is made. A direction is scaled, |D x| = 1.
 */
typedef struct km_second_order_columns {
  const km_mechanism *m;
  km_state *s;
  const km_substructure *sub;
  double residual;         /* of the pose */
  int rank, *primary;      /* [rank] rows of J that the others depend on */
  int *row_start, *column; /* [rows + 1] the entries of J by row: their columns, ascending, */
  int *value_index;        /* and where their values are stored */
  int conditions;
  int *w_start, *w_row;      /* of each condition: the rows in which it has entries, */
  double *w;                 /* and these */
  int *g_start, *g_column;   /* the columns that it depends on, ascending */
  double *J;                 /* [pattern.size] at the pose */
  double *gamma_derivatives; /* [pattern.size] ∂γ/∂x */
  double *gamma;             /* [rows] */
  double *rate;              /* [coordinate] */
  double *value, *g;         /* of each condition; its derivatives, by g_start */
  double *sum;               /* [columns] 0 between conditions */
  double *b, *z;             /* of a step */
  double size;               /* of what the conditions are compared with */
  km_sparse_qr *q;
} km_second_order_columns;

/* At the state's pose, to which km_loops_update was called and at which pivots stop by `tolerance`. KM_MEMORY, KM_IO: SPQR
 * isn't installed. To be freed in any case. O(entries of sparse factors). */
km_status km_second_order_columns_create(const km_mechanism *mechanism, km_state *state, int substructure,
                                         double tolerance, km_arena *arena, km_second_order_columns *out,
                                         km_error *error);
void km_second_order_columns_free(km_second_order_columns *conditions);

/* Does the unit direction x, which closes the loops to first order, break a condition by far more than rounding? The state is
 * at the same pose. */
bool km_second_order_columns_refutes(km_second_order_columns *conditions, const double *x);

/* From the unit direction x, which closes the loops to first order, to one nearby that meets all conditions (damped
 * Gauss-Newton by steps of least |D δx|); false if there is none, or memory is out. The state is at the same pose. A sparse Q R
 * for each of up to 60 steps. */
bool km_second_order_columns_solve(km_second_order_columns *conditions, double *x);

#endif
