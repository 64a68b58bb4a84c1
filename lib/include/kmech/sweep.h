/* Sweeps (theory 10): tables of mobility numbers, mechanical advantage, static forces and redundant constraints along
 * a motion. */
#ifndef KMECH_SWEEP_H
#define KMECH_SWEEP_H

#include "kmech/base.h"
#include "kmech/clearance.h"
#include "kmech/continuation.h"
#include "kmech/data.h"
#include "kmech/mobility.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Plans and common results of all sweeps. */

/* A point whose path a sweep tabulates. */
typedef struct km_sweep_point {
  int frame;        /* index of the model's frame */
  const char *name; /* "body/frame", as in column names */
} km_sweep_point;

enum {
  KM_MAX_SWEEP_STEPS = 10000000 /* most intervals */
};

/* Plan of a sweep. Start from km_sweep_plan_default(). */
typedef struct km_sweep_plan {
  int coordinate;  /* the driver; -1: the model's analysis.sweep */
  double from, to; /* model's unit */
  int steps;       /* intervals; rows = steps + 1. 0: one row at the state's configuration, without motion */
  /* > 0: by arc length, `steps` times this value (more than 1e-8, at most 1000); coordinate, from and to are ignored */
  double arclength;
  /* arc length: coordinate that starts the motion, -1: the one with the largest mobility number */
  int direction;
  double sign; /* sign of that coordinate's motion, +1 or -1 */
  /* arc length, first branch point: 1 (or 0) continues smoothly; 2, 3 take the next branch ahead and back, 4, 5 the
   * one after, … */
  int branch;
  bool cycle;                   /* arc length: KM_PARTIAL unless the motion returns to its start */
  bool ignore_limits;           /* limits do not end the motion */
  const km_sweep_point *points; /* [point_count] points to tabulate */
  int point_count;
  bool derivatives;              /* derivatives of the points by s */
  bool singularities;            /* mobility sweeps: the smallest kept singular value too */
  const km_clearance *clearance; /* mobility and clearance sweeps: clearances of these pairs; NULL: none */
  km_progress progress;
  void *context;
} km_sweep_plan;

/* Rows of a sweep, and the motion. */
typedef struct km_sweep {
  km_table *table;   /* step, s, q., columns of the analysis, dof, dof.k, residual, point. (docs/sweeps.md) */
  km_table *between; /* additional rows near poles, equal columns; step 0 */
  km_mobility first; /* mobility at the start of the sweep */
  int substructure;  /* the moving substructure, -1: a joint in no loop */
  /* freedom of the driven substructure at the start; above 1 the path of least motion is followed */
  int freedom;
  int passive; /* passive ones among them */
  /* infinitesimal ones among them, along the whole motion (permanently shaky mechanism) */
  int infinitesimal;
  bool *passive_coordinates; /* [coordinate] of joints in which passive bodies move; NULL: passive is 0 */
  int start_branches;        /* branches at the start if it is a branch point; else 0 */
  km_motion_end start, end;  /* ends of the motion towards `from` and `to` */
  /* causes of dead points at start and end: the links in line, or the joints whose axes have become dependent; NULL:
   * none or unknown */
  char *causes[2];
  double rank_value
      /* relative singular value that decides a rank change within the closure tolerance at start and end, which is no
       * dead point; else 0 */
      [2];
  km_branch_point *branches; /* branch points; s is the driver's value, or the arc length */
  size_t branch_count, branch_capacity;
  double cycle; /* arc length: length of the closed cycle, 0: not closed */
} km_sweep;

/* Returns the model's own plan, analysis.sweep with a driver; coordinate -1 without one. */
KM_API km_sweep_plan km_sweep_plan_default(const km_model *model);
/* Moves an assembled state that is outside the limits of the driven coordinates to the first configuration within all
 * of them: the driver moves towards `from`, then towards `to`, located to 1e-12. No effect within the limits.
 * KM_NO_RESULT: no configuration of the range is within the limits; KM_USAGE, KM_MEMORY. */
KM_API km_status km_sweep_enter_limits(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                       km_error *error);
KM_API void km_sweep_free(km_sweep *sweep);

/* ---- Mobility numbers along a sweep. */

/* A dead point of a coordinate: its mobility number is 0. */
typedef struct km_toggle {
  int coordinate; /* the coordinate */
  double s;       /* the driver's value (model's unit), or arc length */
} km_toggle;

/* A smallest value along a sweep. */
typedef struct km_extreme {
  double number, s; /* the value and its position */
} km_extreme;

/* A contact of two bodies. */
typedef struct km_contact_event {
  int pair;       /* index of the pair */
  bool separates; /* the bodies separate here along the sweep; else they touch from here on */
  double s;       /* the driver's value, or arc length */
} km_contact_event;

/* Clearances along a sweep. */
typedef struct km_clearance_course {
  const km_clearance *clearance; /* the pairs; NULL: not requested. Borrowed from the plan */
  int pair_count;                /* number of pairs */
  km_extreme *least;             /* [pair_count] least clearance of each pair, over rows and samples between them */
  km_extreme smallest;           /* the least of all, located between the rows; NaN without pairs */
  int smallest_pair;             /* its pair; -1: none */
  km_contact_event *contacts;    /* sorted in the order of the sweep */
  size_t contact_count;
} km_clearance_course;
KM_API void km_clearance_course_free(km_clearance_course *course);

/* A sweep with all mobility numbers, and the events between rows. */
typedef struct km_mobility_sweep {
  km_sweep motion;    /* the table has m. of every coordinate */
  km_toggle *toggles; /* sorted in the order of the sweep */
  size_t toggle_count;
  km_extreme *extremes; /* [coordinate] smallest mobility numbers over the rows */
  km_extreme smallest;  /* smallest kept singular value; NaN unless the plan has singularities */
  km_extreme *minima;   /* its minima along the sweep, located between the rows, in their order */
  size_t minimum_count, minimum_capacity;
  km_clearance_course clearances; /* clearances of plan.clearance, whose columns follow the mobility numbers */
} km_mobility_sweep;

/* Moves the assembled state to `from` without output, then computes steps + 1 rows. If a part of the range is not
 * reached, the rows end (or begin) at the located bound and the status is KM_PARTIAL; start and end give the reason.
 * The rows do not depend on `steps` with one freedom (to 1e-8). With plan.singularities the smallest kept singular
 * value of the moving substructure's J D⁻¹ (lengths over its size, each loop about its own point) is a column and its
 * minima are located; KM_USAGE above KM_MAX_SINGULAR coordinates. KM_CANCELLED, KM_DIVERGED (step limit), KM_MEMORY.
 * Free `*out` in any case. */
KM_API km_status km_mobility_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                       km_mobility_sweep *out, km_error *error);
KM_API void km_mobility_sweep_free(km_mobility_sweep *sweep);

/* ---- Clearances along a sweep (theory 10.7). */

/* A sweep with the clearances of pairs of bodies: columns clearance, the least one, and clearance.<body>/<body>. */
typedef struct km_clearance_sweep {
  km_sweep motion;            /* rows and ends of the sweep */
  km_clearance_course course; /* least values and contacts, located between the rows */
} km_clearance_sweep;

/* Sweeps as km_mobility_sweep_run with the clearances of plan.clearance in every row. Contacts, zeros of a clearance,
 * are located to 1e-9 of the driver; one that begins and ends between two samples, 1/360 of the range apart, is found
 * if three samples show the dip. Free `*out` in any case. */
KM_API km_status km_clearance_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                        km_clearance_sweep *out, km_error *error);
KM_API void km_clearance_sweep_free(km_clearance_sweep *sweep);

/* ---- Velocities and accelerations along a sweep (theory 10.6). */

/* Swing of a coordinate: its extremes over a sweep, located between the rows. */
typedef struct km_swing {
  int coordinate;       /* coordinate that moves */
  double low, high;     /* least and greatest value, the coordinate's unit */
  double s_low, s_high; /* driver values there */
  bool goes_round;      /* a hinge that makes a full turn in one sense */
} km_swing;

/* A sweep with velocities and accelerations for a constant rate of the driver: columns t, v., a. of every coordinate,
 * body.NAME.wx … alphaz (radians), of traced points vx … az, speed, path (length so far) and curvature. Accelerations
 * are NaN with several freedoms. */
typedef struct km_motion_sweep {
  km_sweep motion;  /* rows and ends of the sweep */
  double rate;      /* rate of the driver along the sweep, its unit per time unit */
  km_swing *swings; /* [swing_count] by coordinate */
  int swing_count;
} km_motion_sweep;

/* ---- Mechanical advantage along a sweep (theory 8). */

/* A configuration at which the advantage is 0, infinite or undefined, located by root finding. */
typedef struct km_advantage_toggle {
  km_advantage_state state; /* kind of the value, never finite */
  double s;                 /* the driver's value (model's unit), or arc length */
} km_advantage_toggle;

/* An extreme value of a sweep; s is NaN if there is none. */
typedef struct km_peak {
  double value, s; /* the value; its driver value or arc length */
} km_peak;

/* A sweep with the mechanical advantage, and the events between rows. */
typedef struct km_advantage_sweep {
  km_sweep motion;              /* the table has ma.<input>/<output>, and force_ratio. with friction */
  km_port input, output;        /* the ports */
  size_t column;                /* table column of the advantage */
  bool friction;                /* a joint has friction: the next column is the actual force ratio */
  km_advantage_method method;   /* method in the first row */
  km_advantage_toggle *toggles; /* sorted in the order of the sweep */
  size_t toggle_count;
  /* metrics of the last row, with the reasons of undefined ones; if the transmission was requested */
  km_transmission last;
  km_peak lowest, highest; /* smallest and largest advantage, between rows too; infinite beside a pole */
  km_peak least;           /* value of least magnitude, between rows too */
} km_advantage_sweep;

/* Sweeps as km_mobility_sweep_run, and locates zeros and poles (to 1e-9 of the driver) and extrema of the advantage
 * between rows. `transmission` adds the metrics of km_transmission_compute as columns. KM_USAGE: the ports cannot be
 * input and output (km_transfer_create). Names of the ports are borrowed by `out`. Free `*out` in any case. */
KM_API km_status km_advantage_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                        const km_port *input, const km_port *output, bool transmission,
                                        km_advantage_sweep *out, km_error *error);
KM_API void km_advantage_sweep_free(km_advantage_sweep *sweep);

/* ---- Static balance along a sweep (theory 9.6). */

/* Events of an actuator's force. */
typedef enum km_force_event_kind {
  KM_FORCE_BALANCED, /* zero: the load balances itself */
  KM_FORCE_PEAK,     /* local maximum of the magnitude */
  KM_FORCE_UNBOUNDED /* pole: the actuator is at a dead point against its load */
} km_force_event_kind;

/* An event of an actuator's force. */
typedef struct km_force_event {
  km_force_event_kind kind; /* kind of event */
  int actuator;             /* index of the actuator */
  double s, value;          /* the driver's value or arc length; the force there */
} km_force_event;

/* A sweep with static forces, and the events between rows. */
typedef struct km_statics_sweep {
  km_sweep motion; /* the table has f., fbar., r., held */
  int actuator_count;
  km_port *actuators;     /* [actuator] */
  km_force_event *events; /* sorted in the order of the sweep */
  size_t event_count;
  km_force_event *largest; /* [actuator] largest force, rows and peaks; s NaN: none */
  bool loaded;             /* a load acts at some row */
  size_t unheld;           /* number of rows that the actuators cannot hold */
  double first_unheld;     /* s of the first of them */
  int degree;              /* degree of static indeterminacy in the first row */
  double gravity[3];       /* gravity in effect, length / time² */
} km_statics_sweep;

/* Sweeps as km_mobility_sweep_run, balances the forces in every row, and locates zeros, peaks and poles of the
 * actuators' forces between rows. KM_PARTIAL also if rows cannot be held. Free `*out` in any case. */
KM_API km_status km_statics_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                      km_forces *forces, km_statics *statics, km_statics_sweep *out, km_error *error);
KM_API void km_statics_sweep_free(km_statics_sweep *sweep);

/* ---- Redundant constraints along a sweep: persistent and additional ones (theory 7.3). */

/* A position with more redundant constraints, and as much more mobility, than the least of the sweep. */
typedef struct km_extra_redundancy {
  double s; /* the driver's value, or arc length */
  int more; /* number of additional redundant constraints */
} km_extra_redundancy;

/* Redundant constraints along a sweep. */
typedef struct km_sweep_redundancies {
  km_redundancies persistent; /* if requested: named at a row of least mobility, redundant in every row */
  km_extra_redundancy *extra; /* rows and branch points with additional ones, by s */
  size_t extra_count;
} km_sweep_redundancies;

/* Counts redundant constraints from the ranks in the rows (6 · loops + couplings − rank). `named`: the persistent
 * ones are named too, on a state of its own. KM_USAGE, KM_MEMORY. Free `*out` in any case. */
KM_API km_status km_sweep_redundancies_find(const km_mechanism *mechanism, const km_sweep *sweep, bool named,
                                            km_sweep_redundancies *out, km_error *error);
KM_API void km_sweep_redundancies_free(km_sweep_redundancies *redundancies);

/* ---- Allowance of redundant constraints (theory 14.9) */

/* Tolerances and play of joints that state none. */
typedef struct km_fit_defaults {
  double position;  /* tolerance of a joint's place on each of its bodies, model's length unit */
  double direction; /* tolerance of its axes on each of its bodies, radians */
  double play;      /* play in every direction that a joint constrains, model's length unit */
  double angle;     /* angular play about every axis that a joint constrains, radians */
  bool states_play; /* the play is that of the parts; else a scale of the ratio */
} km_fit_defaults;

/* A redundant constraint: a component of the misfit where a loop is closed last. */
typedef struct km_allowance_constraint {
  int joint;     /* joint that closes the loop, -1: a coupling */
  int component; /* 0 1 2: along x y z of the joint's parent frame; 3 4 5: about them; index of the coupling */
  /* largest misfit over the rows, in the worst case and for 99.73 % of the mechanisms at one position: length unit,
   * or radians */
  km_peak worst, statistical;
} km_allowance_constraint;

/* A joint of an overconstrained substructure. */
typedef struct km_allowance_joint {
  int joint; /* index in the model */
  /* largest ratio over the rows if this joint alone has play, as km_allowance_sweep.worst; infinite: it can't take up
   * all misfits */
  double alone_worst, alone_statistical;
  double play_share, error_share; /* its share of the play and of the errors where the ratio is worst, 0 to 1 */
  /* largest force and moment in it over the rows if no joint has play and stated stiffnesses take up the misfits; in
   * the worst case at most this, and 3 standard deviations; NaN: no stiffness is stated, or it can't take them up */
  double force_worst, force_statistical, moment_worst, moment_statistical;
} km_allowance_joint;

/* A sweep with the play that errors of redundant dimensions need. */
typedef struct km_allowance_sweep {
  km_sweep motion; /* the table has play.worst, play.statistical, gap.<joint>.<component>.worst and .statistical */
  km_fit_defaults defaults; /* as given */
  bool states_clearance;    /* the defaults or a joint of the model state the play */
  /* largest ratio of play that is needed to play that the joints have, over the rows: above 1 the mechanism can bind */
  km_peak worst, statistical;
  int constraint_count;
  km_allowance_constraint *constraints; /* [constraint_count] */
  int joint_count;
  km_allowance_joint *joints; /* [joint_count] */
  int set_count;
  int *set;                          /* [set_count] few joints whose play alone suffices, indices in the model */
  double set_worst, set_statistical; /* ratio if only these have play */
  km_remedy_set remedies;            /* joint types that need no play */
} km_allowance_sweep;

/* Sweeps as km_mobility_sweep_run. At each row the misfits of the redundant constraints are compared with the play of
 * the joints,
 *
 *   ratio = max over self-stresses a of h(a)/c(a),   h: virtual work of the errors, c: of the play
 *
 * worst case: all errors at their tolerances; statistical: normal errors with a third of the tolerance as standard
 * deviation. Rows with more redundant constraints than nearby have NaN. KM_USAGE: a default is negative or not finite,
 * or a substructure has more than KM_MAX_ALLOWANCE redundant constraints. KM_MEMORY, KM_CANCELLED, KM_PARTIAL as other
 * sweeps. Cost: rows · (joints · redundant constraints² · steps of the ratio), some ten microseconds a row for one
 * loop. Free `*out` in any case. */
KM_API km_status km_allowance_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                        const km_fit_defaults *defaults, km_allowance_sweep *out, km_error *error);
KM_API void km_allowance_sweep_free(km_allowance_sweep *sweep);

enum { KM_MAX_ALLOWANCE = 60 }; /* redundant constraints of one substructure */

#ifdef __cplusplus
}
#endif
#endif
