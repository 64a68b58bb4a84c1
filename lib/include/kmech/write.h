/* Models as the text of files. */
#ifndef KMECH_WRITE_H
#define KMECH_WRITE_H

#include "kmech/bytes.h"
#include "kmech/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A model in its own format (JSON), in its own units; all that was read is kept. `q` [coordinate count]: initial
 * displacements in the model's units, NULL: the model's own. The caller frees `*out`. KM_USAGE, KM_MEMORY. Cost: linear
 * in the file. */
KM_API km_status km_model_write(const km_model *model, const double *q, km_bytes *out, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
