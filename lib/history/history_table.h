/* Rows of a motion over time: what simulations and prescribed motions write down alike. Private to analysis/. */
#ifndef KM_HISTORY_HISTORY_TABLE_H
#define KM_HISTORY_HISTORY_TABLE_H

#include "history/dynamic_friction.h"
#include "history/history_limits.h"
#include "kmech/dynamics.h"

/* Rows of a motion in the making. */
typedef struct km_history_writer {
  const km_mechanism *m;
  const km_traced_frame *frames;
  int frame_count;
  bool reactions, mobility, shaking;
  km_axes axes;
  km_forces *forces;
  km_state *state, *look; /* `look`: a copy whose partitions may be searched */
  km_dynamics *dynamics;
  km_dynamic_friction *rubbing;
  km_simulation *simulation; /* NULL: the motion is known, and nothing is integrated */
  km_statics statics;
  double potential;     /* at the start */
  km_exceeded *watched; /* [watched_count] drives that have a bound, and the most that was asked of them */
  int watched_count;
  km_limit_watch limits;
  km_history *out;
} km_history_writer;

/* Begins to watch the limits that no stop guards; `simulation` (NULL: nothing is integrated) then has their crossings beside
 * its own. KM_MEMORY. */
km_status km_history_watch_limits(km_history_writer *writer, km_simulation_def *simulation, km_error *error);
/* Makes what reactions and mobility numbers need, and the table with its columns, and takes the energies at the state
 * for those of the start. KM_MEMORY. */
km_status km_history_begin(km_history_writer *writer, km_error *error);
/* Adds a row at the state, whose accelerations are at hand. KM_MEMORY. */
km_status km_history_row(km_history_writer *writer, km_error *error);
/* Empties the result and checks what every such function is given. */
km_status km_history_check(const km_mechanism *mechanism, const km_forces *forces, const km_state *state,
                           const void *def, km_history *out, km_error *error);
/* Hands over why a motion ended early (NULL: as it was asked to), and frees all but the result, the forces and the state. Returns `status`. */
km_status km_history_end(km_history_writer *writer, km_status status, const km_error *why, km_error *error);
km_status km_history_check_frames(const km_mechanism *mechanism, const km_traced_frame *frames, int count,
                                  km_error *error);

#endif
