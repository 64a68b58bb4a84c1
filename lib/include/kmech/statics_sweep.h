/* Static balance over a sweep. */
#ifndef KMECH_STATICS_SWEEP_H
#define KMECH_STATICS_SWEEP_H

#include "kmech/statics.h"
#include "kmech/sweep_plan.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What happens to an actuator's force between rows. */
typedef enum km_force_event_kind {
  KM_FORCE_BALANCED, /* the load balances itself: the actuator holds nothing */
  KM_FORCE_PEAK,     /* the actuator's force is larger than at either side */
  KM_FORCE_UNBOUNDED /* the actuator is at a toggle against its load: no force is enough */
} km_force_event_kind;

/* A place of a sweep where an actuator's force is special. */
typedef struct km_force_event {
  km_force_event_kind kind; /* what it is */
  int actuator;             /* into the statics' actuators */
  double s, value;          /* where: the driver, or arc length; the force there */
} km_force_event;

/* The rows of a sweep with the forces that hold them. */
typedef struct km_statics_sweep {
  km_sweep motion; /* its table has f., fbar., r., held */
  int actuator_count;
  km_handle *actuators;   /* [actuator] */
  km_force_event *events; /* in the order of the sweep */
  size_t event_count;
  km_force_event *largest; /* [actuator] where its force is largest, rows and peaks; s NaN: it never holds */
  bool loaded;             /* something acts at some row */
  size_t unheld;           /* rows that the actuators can't hold */
  double first_unheld;     /* s of the first of them */
  int degree;              /* of static indeterminacy, at the first row */
  double gravity[3];       /* that counted, length / time² */
} km_statics_sweep;

/* Sweeps as km_mobility_sweep_run does, balances the forces at every row, and looks between the rows for where an
 * actuator's force vanishes, peaks or grows without bound. KM_PARTIAL too where rows can't be held. Free `*out` in any
 * case. */
KM_API km_status km_statics_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                      km_forces *forces, km_statics *statics, km_statics_sweep *out, km_error *error);
KM_API void km_statics_sweep_free(km_statics_sweep *sweep);

#ifdef __cplusplus
}
#endif
#endif
