/* Other values for some numbers of a file, put in before it is read. */
#ifndef KM_EXCHANGE_JSON_NUMBER_VARIATION_H
#define KM_EXCHANGE_JSON_NUMBER_VARIATION_H

#include "base/value.h"
#include "kmech/model.h"

/* Enters the values into the tree; for paths see km_model_read_varied. KM_USAGE, KM_MEMORY. */
km_status km_model_vary(km_value *root, const km_assignment *assignments, int count, km_arena *arena, km_error *error);
/* The value of the number that a path names; NaN where the file doesn't state it. KM_USAGE, KM_MEMORY. */
km_status km_model_find_number(km_value *root, const char *path, double *value, km_error *error);

#endif
