/* A simulation as a table: coordinates, rates, accelerations, energies, points and reactions over time. */
#ifndef KMECH_HISTORY_H
#define KMECH_HISTORY_H

#include "kmech/simulation.h"
#include "kmech/statics.h"
#include "kmech/table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A frame that the table follows; its name is borrowed. */
typedef struct km_followed_frame {
  int frame;        /* of the model */
  const char *name; /* "body/frame" */
} km_followed_frame;

/* What to write down. Times in the model's time unit; start from km_history_default(). */
typedef struct km_history_def {
  km_simulation_def simulation; /* crossings and frames are borrowed; `end` is set to `until` */
  double start;                 /* the time at which the motion begins; 0 */
  double until, every;          /* the end, and the time between rows, of which there are at most KM_MOST_SWEEP_STEPS */
  const km_followed_frame *frames; /* whose origins are written down */
  int frame_count;
  bool reactions; /* of every joint, too */
  km_axes axes;   /* of the reactions */
  bool mobility;  /* mobility numbers, too */
  km_progress progress;
  void *context;
} km_history_def;
/* The model's own simulation settings where it has some. */
KM_API km_history_def km_history_default(const km_model *model);

/* A joint's drive that goes beyond its max_force or max_rate: the most of all rows. */
typedef struct km_exceeded {
  int coordinate;     /* of the drive */
  bool of_force;      /* else of the rate */
  double most;        /* by size: a force, or of angles a torque; or the coordinate's unit over the time unit */
  double time, bound; /* when; what the drive can give */
} km_exceeded;

/* A joint that passes a limit where no stop acts (`stop` of the model): where it does so first, and how far it goes. */
typedef struct km_passed_limit {
  int coordinate; /* which passes; of a ball's angle its first one */
  bool upper;     /* the upper limit */
  double limit;   /* the coordinate's unit */
  double time;    /* when; of a run located between rows */
  double beyond;  /* the furthest of all rows past its limits, the coordinate's unit */
} km_passed_limit;

/* A stated initial rate that the loops, or rates that come before it, don't allow. */
typedef struct km_changed_rate {
  int coordinate;       /* whose */
  double stated, start; /* as stated; as the motion starts: the coordinate's unit over the time unit */
  bool by_model;        /* stated by the model; else by km_state_set_rate, which comes before the model */
} km_changed_rate;

/* The largest force of a prescribed motion, located between rows too, and its root mean square over the motion's time. */
typedef struct km_force_peak {
  int coordinate; /* whose driving force; -1: the size of the shaking force */
  size_t column;  /* its first one in the table, */
  int parts;      /* of so many */
  double value;   /* as in the table; largest by size */
  double time;    /* when */
  double rms;     /* sqrt(1/T ∫ f² dt) by the trapezoidal rule over the rows */
} km_force_peak;

/* What a simulation gave. */
typedef struct km_history {
  km_table *table;               /* a row for each time */
  km_simulation_figures figures; /* how the run went */
  km_crossing_met *crossings;    /* in order of time */
  int crossing_count;
  km_exceeded *exceeded; /* by coordinate; motors, controllers and prescribed motions are drives */
  int exceeded_count;
  km_passed_limit *limits; /* by coordinate */
  int limit_count;
  km_changed_rate *changed_rates; /* by coordinate; empty where the stated initial rates agree */
  int changed_rate_count;
  km_force_peak *peaks; /* of km_inverse_run: of every driving force, then of the shaking force */
  int peak_count;
  double rate_change;  /* share of the stated initial rates that had to change so that the loops stay closed */
  double worst_loop;   /* largest rms loop error of a row, scaled (235) */
  double energy_error; /* largest change of kinetic + potential + dissipated − motor work, force × length */
  double energy_scale; /* largest kinetic energy: what it is compared with */
  double energy_start; /* kinetic energy at the start */
  km_effort effort;    /* of an evaluation's solution */
  km_error why;        /* of a run that ended early */
} km_history;

/* Columns: t; q., v., a. of every coordinate; f. of prescribed joints, the force that drives them; energy_kinetic,
 * energy_potential (0 at the start), energy_dissipated, motor_work; loop_error, evaluations, repartitions; frame.NAME.x
 * … of followed frames: place, velocity and acceleration of its origin in the inertial frame; r.LABEL.fx … tz reactions
 * of parent on child; m.LABEL mobility numbers. From the assembled state's pose and rates. KM_PARTIAL: a
 * crossing ended the run. KM_DIVERGED, KM_CANCELLED: the table holds what was reached, `why` tells the reason. Else as
 * km_simulation_create. Free `*out` in any case. */
KM_API km_status km_history_run(const km_mechanism *mechanism, km_forces *forces, km_state *state,
                                const km_history_def *def, km_history *out, km_error *error);
KM_API void km_history_free(km_history *history);

#ifdef __cplusplus
}
#endif
#endif
