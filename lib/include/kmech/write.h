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

/* The formats that a model is written in. */
typedef enum km_model_format {
  KM_FORMAT_JSON,
  KM_FORMAT_URDF, /* a tree: joints that close loops are left out */
  KM_FORMAT_MJCF, /* loops by constraints */
  KM_FORMAT_SDF   /* loops as joints */
} km_model_format;
/* The format that the ending of a file's name tells: .urdf, .xml (MJCF), .sdf; JSON for all others. */
KM_API km_model_format km_model_format_of(const char *file);

/* The model in one of these formats, at a pose in which its loops are closed (q as above). Robot descriptions are in SI
 * units. What a format can't hold is a note in `messages`, one for each kind, with the number. What is read back is the
 * same mechanism: mobility, poses at the same coordinates, masses, gravity. In SDF the joints of loops count from the pose
 * that is written; in MJCF ball joints do. The caller frees `*out`. KM_MODEL: the loops are open; KM_USAGE, KM_MEMORY. Cost:
 * bodies · joints. */
KM_API km_status km_model_write_as(const km_model *model, km_model_format format, const double *q,
                                   km_messages *messages, km_bytes *out, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
