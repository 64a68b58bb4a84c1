/* The column of a coordinate in a table (model/coordinate_column.h). */
#include "model/coordinate_column.h"

bool km_model_add_coordinate_column(const km_model *model, int coordinate, km_table *table) {
  return km_table_add_joined_column(table, "q.", model->coordinates[coordinate].label, "",
                                    km_model_coordinate_unit(model, coordinate));
}
