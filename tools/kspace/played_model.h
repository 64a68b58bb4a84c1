/* A model whose drivers follow a path over time. */
#ifndef KSPACE_PLAYED_MODEL_H
#define KSPACE_PLAYED_MODEL_H

#include "common/common.h"
#include "kmech/data.h"

/* Writes BASE.path.json: the model's file with `prescribed` tables of the drivers, columns 1 … of the motion over its
 * part of `time` in column 0. */
kt_exit kspace_write_played_model(const kt_common *common, const char *file, const km_model *model,
                                  const km_table *motion, const int *drivers, int count, double time, const char *base);

#endif
