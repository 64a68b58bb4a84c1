/* Rows of a motion over time, for simulations and inverse dynamics. Private to history/. */
#ifndef KM_HISTORY_HISTORY_TABLE_H
#define KM_HISTORY_HISTORY_TABLE_H

#include "history/dynamic_friction.h"
#include "history/history_limits.h"
#include "kmech/dynamics.h"

/* Writer of the rows of a motion. */
typedef struct km_history_writer {
  const km_mechanism *m;
  const km_traced_frame *frames;
  int frame_count;
  bool frame_rotations;
  const int *modules; /* [module_count] */
  int module_count;
  bool reactions, mobility, shaking, kinematics_only;
  km_axes axes;
  km_forces *forces;
  km_state *state, *probe; /* `probe`: copy for analyses that change partitions */
  km_dynamics *dynamics;
  km_dynamic_friction *friction;
  km_simulation *simulation; /* NULL: prescribed motion without integration */
  km_statics statics;
  const km_run_memory *memory; /* end of the run that this one continues; NULL: none */
  double potential;            /* potential energy that counts as 0 */
  double balance;              /* kinetic + potential + dissipated − motor work at the start */
  km_exceeded *monitored;      /* [monitored_count] drives with a bound, and their largest force or rate */
  int monitored_count;
  km_limit_monitor limits;
  km_history *out;
} km_history_writer;

/* Begins to monitor the limits without stops; their crossings are added to those of `simulation` (NULL: no
 * integration). KM_MEMORY. */
km_status km_history_monitor_limits(km_history_writer *writer, km_simulation_def *simulation, km_error *error);
/* Prepares reactions and mobility numbers, creates the table with its columns, and stores the energies at the start.
 * KM_MEMORY. */
km_status km_history_begin(km_history_writer *writer, km_error *error);
/* Adds a row at the state, whose accelerations are computed. KM_MEMORY. */
km_status km_history_row(km_history_writer *writer, km_error *error);
/* Adds the columns of the tabulated force modules; and their cells at the last evaluation, returning the next cell. */
void km_history_module_columns(const km_history_writer *writer, km_table *table, bool *failed);
double *km_history_write_modules(const km_history_writer *writer, double *out);
/* Adds the columns of the internal states of force modules, and their cells. */
void km_history_internal_columns(const km_history_writer *writer, km_table *table, bool *failed);
double *km_history_write_internal(const km_history_writer *writer, double *out);
/* Column name and unit of an internal state, see km_model_internal_count. */
void km_internal_column(const km_model *model, int index, km_text *name, km_text *unit);
/* Clears the result and checks the common arguments. */
km_status km_history_check(const km_mechanism *mechanism, const km_forces *forces, const km_state *state,
                           const void *def, km_history *out, km_error *error);
/* Stores the reason why a motion ended early (NULL: regular end) and frees everything except the result, the forces
 * and the state. Returns `status`. */
km_status km_history_end(km_history_writer *writer, km_status status, const km_error *why, km_error *error);
km_status km_history_check_frames(const km_mechanism *mechanism, const km_traced_frame *frames, int count,
                                  km_error *error);

#endif
