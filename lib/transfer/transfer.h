/* Data of a transfer from an input to an output. Private to the library. */
#ifndef KM_TRANSFER_TRANSFER_H
#define KM_TRANSFER_TRANSFER_H

#include "forces/forces.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"
#include "local/constant_rank.h"

/* Rate of a port as a linear function of the coordinates' rates: Σ row[c] q̇_c. */
typedef struct km_transfer_end {
  km_port port;
  double *row;   /* [coordinate] */
  double *speed; /* [coordinate] speed of a point at unit rate */
  double rate;   /* in the transfer's motion */
  double size;   /* scale of comparison for a rate of zero */
} km_transfer_end;

struct km_transfer {
  km_arena arena;
  const km_mechanism *mechanism;
  km_transfer_end input, output;
  bool *moves;                     /* [coordinate] it belongs to the input: to its joints or their substructures */
  double *rates;                   /* [coordinate] */
  km_pose *pose;                   /* [body] about a point near the mechanism */
  km_constant_rank *constant_rank; /* [substructure] constant-rank motions of permanently shaky mechanisms */
  bool *is_tested;                 /* [substructure] constant_rank is initialised */
  bool *uses_constant_rank;        /* [substructure] constant_rank applies at the configuration */
};

/* "input", "output". */
const char *km_end_word(bool output);
/* Checks the ports of a public function: KM_USAGE unless both are joints or points of the mechanism. */
km_status km_check_ports(const km_mechanism *mechanism, const km_port *input, const km_port *output, km_error *error);

/* Creates a load of 1 against the output, at its point or in its joint, and its static balance; a joint as input is the
 * actuator. KM_MEMORY. The caller frees both in any case. */
km_status km_unit_load_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                              km_forces **forces, km_statics *statics, km_error *error);
/* Computes the advantage in a given motion, rates[coordinate]: at a branch point the followed one. */
void km_transfer_along(const km_mechanism *mechanism, const km_state *state, km_transfer *transfer, const double *rates,
                       km_advantage *out);

#endif
