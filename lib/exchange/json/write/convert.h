/* Argument checks of the writers of the model format. */
#ifndef KM_EXCHANGE_JSON_WRITE_CONVERT_H
#define KM_EXCHANGE_JSON_WRITE_CONVERT_H

#include "base/value.h"
#include "kmech/exchange.h"
#include "model/model.h"

/* KM_USAGE: something is missing, or a displacement isn't finite. */
km_status km_check_convert(const km_model *model, const km_units *units, const double *q, const km_arena *arena,
                           const km_value **out, km_error *error);

#endif
