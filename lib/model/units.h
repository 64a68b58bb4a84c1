/* Unit tables and products of dimensions; public functions are in kmech/model.h. */
#ifndef KM_MODEL_UNITS_H
#define KM_MODEL_UNITS_H

#include "kmech/model.h"

#include <stdbool.h>

/* Units of one quantity; the last entry has no word. */
const km_unit *km_quantity_units(km_quantity quantity);
km_dimension km_dimension_product(km_dimension a, km_dimension b);
km_dimension km_dimension_power(km_dimension a, int n); /* dimension to the power n, of any sign */

#endif
