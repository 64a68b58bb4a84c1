/* The column "q.LABEL_unit" of a coordinate in a table. */
#ifndef KM_MODEL_COORDINATE_COLUMN_H
#define KM_MODEL_COORDINATE_COLUMN_H

#include "base/table.h"
#include "model/model.h"

/* Adds the column. False when out of memory. */
bool km_model_add_coordinate_column(const km_model *model, int coordinate, km_table *table);

#endif
