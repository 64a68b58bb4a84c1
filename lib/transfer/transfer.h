/* An input and an output at a pose. Private to analysis/. */
#ifndef KM_TRANSFER_TRANSFER_H
#define KM_TRANSFER_TRANSFER_H

#include "kmech/transfer.h"
#include "local/constant_rank_motion.h"

/* How an end moves with the coordinates: its rate is Σ row[c] q̇_c. */
typedef struct km_transfer_end {
  km_port handle;
  double *row;   /* [coordinate] */
  double *speed; /* [coordinate] of a point: its whole speed at unit rate */
  double rate;   /* in the lever's motion */
  double size;   /* what rounding of that rate is measured by */
} km_transfer_end;

struct km_transfer {
  km_arena arena;
  const km_mechanism *mechanism;
  km_transfer_end input, output;
  bool *moves;              /* [coordinate] the input's rate depends on it, or on its substructure */
  double *rates;            /* [coordinate] */
  km_pose *pose;            /* [body] about a point near the mechanism */
  km_constant_rank *steady; /* [substructure] where the mechanism shakes all along */
  bool *asked;              /* [substructure] for that */
  bool *is_steady;          /* [substructure] so at the pose that the motion is chosen for */
};

/* "input", "output". */
const char *km_end_word(bool output);
/* For public functions: KM_USAGE unless both are joints or points of the mechanism. */
km_status km_check_ports(const km_mechanism *mechanism, const km_port *input, const km_port *output, km_error *error);

/* The advantage in a given motion, rates[coordinate]: at a branch point the one that is followed. */
void km_transfer_along(const km_mechanism *mechanism, const km_state *state, km_transfer *lever, const double *rates,
                       km_advantage *out);

#endif
