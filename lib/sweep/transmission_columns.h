/* Columns about the transmission from an input to an output (theory 8.3, 8.4). Private to the library. */
#ifndef KM_SWEEP_TRANSMISSION_COLUMNS_H
#define KM_SWEEP_TRANSMISSION_COLUMNS_H

#include "base/table.h"
#include "kmech/sweep.h"
#include "kmech/transfer.h"
#include "transfer/joint_transmission.h"

typedef struct km_transmission_columns {
  const km_mechanism *mechanism;
  int input;                          /* coordinate of the input; -1: a point */
  km_transmission_workspace *metrics; /* metrics of a single loop and of the Jacobian */
  km_joint_transmission *joints;
  size_t first;         /* first of its columns in the table */
  km_transmission last; /* metrics of the last row */
  bool failed;          /* out of memory */
} km_transmission_columns;

/* Creates the workspace. KM_USAGE, KM_MEMORY. Free in any case. */
km_status km_transmission_columns_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                                         km_transmission_columns *out, km_error *error);
void km_transmission_columns_free(km_transmission_columns *columns);
/* Adds the columns. False: no memory. */
bool km_transmission_columns_add(km_transmission_columns *columns, const km_port *output, km_table *table);
/* Writes the cells of a row at the state's configuration and returns the next cell. `rates`: the motion there. */
double *km_transmission_columns_write(km_transmission_columns *columns, km_state *state, const double *rates,
                                      double *cell);
/* Divides the quality indices of all rows by their greatest values. A column without a value stays so. */
void km_transmission_columns_finish(const km_transmission_columns *columns, km_sweep *sweep);

#endif
