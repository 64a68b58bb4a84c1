/* Models in the model format. */
#ifndef KM_EXCHANGE_JSON_JSON_MODEL_H
#define KM_EXCHANGE_JSON_JSON_MODEL_H

#include "model/model.h"

/* Reads a model from JSON text; see km_model_read_as. */
km_status km_json_model(const char *bytes, size_t size, const km_read_def *def, km_messages *messages, km_model **out,
                        km_error *error);

#endif
