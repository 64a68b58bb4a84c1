/* A model whose drivers follow a path over time. */
#ifndef KSPACE_PLAYED_MODEL_H
#define KSPACE_PLAYED_MODEL_H

#include "common/common.h"
#include "kmech/data.h"

/* Writes BASE.path.json: the model's file with `prescribed` tables of the drivers, columns 1 … of the path over its
 * length in column 0. The speed is that of a cycloid: the motion begins and ends at rest. */
kt_exit kspace_write_played_model(const kt_common *common, const char *file, const km_model *model,
                                  const km_table *path, const int *drivers, int count, double time, const char *base);

#endif
