/* Second-order conditions by columns: back end of the local analysis for many freedoms (docs/theory.md 5.5). Private to
 * local/. */
#ifndef KM_LOCAL_SECOND_ORDER_COLUMNS_H
#define KM_LOCAL_SECOND_ORDER_COLUMNS_H

#include "local/local_private.h"

/* Creates the conditions at the analysed configuration, where the state is. KM_MEMORY; KM_IO: SPQR is not installed.
 * O(entries of the sparse factors). */
km_status km_second_order_columns_create(km_local *local, km_error *error);
void km_second_order_columns_free(km_second_order_columns *conditions);

/* Computes values and derivatives of all conditions along the tangent a[columns]; returns the largest |value|, in units
 * of w_i, and in *steepest the largest length of a derivative. The state is at the configuration. */
double km_second_order_columns_evaluate(km_local *local, const double *a, double *steepest);
/* Adds the minimum-norm step with J_p D⁻¹ δ = 0, δ ⊥ a, and the conditions over their scale damped. False when out of
 * memory. */
bool km_second_order_columns_step(km_local *local, double damping, double *a);

#endif
