/* Transmission and pressure angles of the hinges of a planar linkage of any number of loops, and the joint force index
 * (theory 8.4). Private to the library. */
#ifndef KM_TRANSFER_JOINT_TRANSMISSION_H
#define KM_TRANSFER_JOINT_TRANSMISSION_H

#include "base/table.h"
#include "kinematics/body_poses.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"

typedef struct km_joint_transmission {
  km_arena arena;
  const km_mechanism *mechanism;
  km_port output;
  km_forces *forces;
  km_statics statics;
  int substructure;       /* substructure of the input; -1: it is in no loop, nothing is computed */
  bool planar;            /* all its loops are planar */
  int count;              /* number of hinges between moving links; 0: not a planar linkage driven at a joint */
  int *joint;             /* [count] joints of the model */
  double *zero;           /* [coordinate] */
  km_body_motion *motion; /* [body] */
} km_joint_transmission;

/* Creates the workspace for a driving `input` and an `output`. KM_MEMORY. The caller frees `*out`. */
km_status km_joint_transmission_create(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                                       km_joint_transmission **out, km_error *error);
void km_joint_transmission_free(km_joint_transmission *work);
/* Adds the columns transmission.JOINT and pressure.JOINT of each hinge, and joint_force_index. False: no memory. */
bool km_joint_transmission_columns(const km_joint_transmission *work, km_table *table);
/* Number of its columns. */
size_t km_joint_transmission_count(const km_joint_transmission *work);
/* Writes both angles of each hinge in the motion `rates` [coordinate], in the model's unit; NaN where the hinge rests,
 * carries no force, or the input doesn't hold the output's load; then the joint force index, NaN where statics leaves a
 * force open. Requires the state's mobility. False when out of
 * memory. */
bool km_joint_transmission_compute(km_state *state, km_joint_transmission *work, const double *rates, double *cells);

#endif
