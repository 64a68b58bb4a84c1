/* Units inside of the library: kmech/model.h, their tables, and dimensions that are multiplied. */
#ifndef KM_MODEL_UNITS_H
#define KM_MODEL_UNITS_H

#include "kmech/model.h"

#include <stdbool.h>

/* The table of one quantity, ended by an entry without word. */
const km_unit *km_quantity_units(km_quantity quantity);
km_dimension km_dimension_product(km_dimension a, km_dimension b);
km_dimension km_dimension_power(km_dimension a, int n); /* n of any sign */

#endif
