/* Sweeps: plans, and the mobility numbers, mechanical advantage, static forces and redundant constraints along a
 * motion. */
#ifndef KMECH_SWEEP_H
#define KMECH_SWEEP_H

#include "kmech/base.h"
#include "kmech/continuation.h"
#include "kmech/data.h"
#include "kmech/mobility.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Sweeps: what to move, over which range, and what every sweep gives, whatever it looks at. */

/* A point whose way a sweep writes down. */
typedef struct km_sweep_point {
  int frame;        /* of the model */
  const char *name; /* "body/frame", as the columns call it */
} km_sweep_point;

enum {
  KM_MAX_SWEEP_STEPS = 10000000 /* the most intervals */
};

/* What to sweep. Start from km_sweep_plan_default(). */
typedef struct km_sweep_plan {
  int coordinate;  /* the driver; -1: the model's analysis.sweep */
  double from, to; /* model's unit */
  int steps;       /* intervals; rows = steps + 1. 0: one row at the state's pose, where nothing moves */
  /* > 0: by arc length instead, `steps` times this much (more than 1e-8, at most 1000); coordinate, from, to don't count */
  double arclength;
  int direction;      /* the coordinate that starts the motion, -1: the one with the largest mobility number */
  double sign;        /* +1 or -1 */
  int branch;         /* by arc length, at the first branch point: 1 (or 0) goes on smoothly; 2, 3 take the next motion
                     * ahead and back, 4, 5 the one after, … */
  bool cycle;         /* by arc length: KM_PARTIAL unless the motion comes back to its start */
  bool ignore_limits; /* joints go beyond their limits */
  const km_sweep_point *points; /* [point_count] whose way is written down */
  int point_count;
  bool derivatives;   /* of the points along s */
  bool singularities; /* of mobility sweeps: the smallest kept singular value too */
  km_progress progress;
  void *context;
} km_sweep_plan;

/* The rows of a sweep, and how the mechanism moved. */
typedef struct km_sweep {
  km_table *table;          /* step, s, q.; the columns of what is looked at; dof, dof.k, residual, point. (cli.md) */
  km_table *between;        /* the same columns at poses between rows, where a curve grows without bound; step 0 */
  km_mobility first;        /* at the pose from which the sweep started */
  int substructure;         /* the one that moves, -1: a joint in no loop */
  int freedom;              /* of the driven substructure there: above 1 the others move least */
  int idle;                 /* how many of them are idle (kmech/idle.h): nothing else feels them */
  int shaking;              /* how many of them no motion follows, though first order allows them all along */
  bool *idle_coordinates;   /* [coordinate] of joints that idle bodies turn in; NULL: idle is 0 */
  int start_branches;       /* motions that meet at the starting pose, where it is a branch point; else 0 */
  km_motion_end start, end; /* how FROM and TO were reached */
  char *causes[2]; /* of start and end at a dead point: the links that are in line, or the joints whose axes are
                              * dependent; NULL: none, or it can't be told */
  double rank_value
      [2]; /* of start and end where the rank changes within the closure tolerance, which is no dead point: the
                              * singular value that decides it, over the largest; else 0 */
  km_branch_point *branches; /* where several motions meet; s is the driver's value, or the arc length */
  size_t branch_count, branch_capacity;
  double cycle; /* by arc length: length of the closed cycle, 0 if it wasn't closed */
} km_sweep;

/* The model's own plan: analysis.sweep with a driver. coordinate -1 where it has none. */
KM_API km_sweep_plan km_sweep_plan_default(const km_model *model);
/* Where the assembled state's pose is outside the limits of what the plan's driver moves: moves the driver towards
 * FROM, then towards TO, to the first pose where they all hold, located to 1e-12; from there on they count.
 * KM_NO_RESULT if there is none: then no pose of the range is in reach, and a sweep has no row. */
KM_API km_status km_sweep_enter_limits(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                       km_error *error);
KM_API void km_sweep_free(km_sweep *sweep);

/* ---- Mobility numbers over the range of a driver. */

/* A pose at which a coordinate's mobility number passes through 0. */
typedef struct km_toggle {
  int coordinate; /* whose number is 0 there */
  double s;       /* of the driver, model's unit */
} km_toggle;

/* A smallest value along a sweep. */
typedef struct km_extreme {
  double number, s; /* a smallest value, and where */
} km_extreme;

/* The rows of a sweep with every mobility number, and what lies between the rows. */
typedef struct km_mobility_sweep {
  km_sweep motion;    /* its table has m. of every coordinate */
  km_toggle *toggles; /* in the order of the sweep */
  size_t toggle_count, toggle_capacity;
  km_extreme *extremes; /* [coordinate] smallest mobility numbers over the rows */
  km_extreme smallest;  /* singular value over the sweep; NaN unless the plan asks for singularities */
  km_extreme *minima;   /* of it along the sweep, located between the rows, in their order */
  size_t minimum_count, minimum_capacity;
} km_mobility_sweep;

/* Moves the assembled state from its pose to `from` without output, then gives steps + 1 rows. Where a part of
 * the range is out of reach the rows end (or begin) at the located bound and the status is KM_PARTIAL; start
 * and end say why. With one freedom the rows don't depend on `steps` (to 1e-8). With plan.singularities, the smallest
 * kept singular value of the moving substructure's J D⁻¹ (rows: lengths over its size, each loop about a point of its
 * own) is a column, and its minima are located; KM_USAGE above KM_MAX_SINGULAR coordinates. Free `*out` in any case.
 */
KM_API km_status km_mobility_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                       km_mobility_sweep *out, km_error *error);
KM_API void km_mobility_sweep_free(km_mobility_sweep *sweep);

/* ---- Mechanical advantage over a sweep. */

/* A pose at which the advantage is 0, infinite or undefined, located by root finding. */
typedef struct km_advantage_toggle {
  km_advantage_state state; /* the advantage there, never finite */
  double s;                 /* of the driver, model's unit, or arc length */
} km_advantage_toggle;

/* A value of a sweep, and where; s is NaN if there is none. */
typedef struct km_peak {
  double value, s; /* the extreme; of the driver or arc length */
} km_peak;

/* The rows of a sweep with their advantages, and what lies between the rows. */
typedef struct km_advantage_sweep {
  km_sweep motion;              /* its table has ma.<input>/<output>, and force_ratio. where joints have friction */
  km_port input, output;        /* the ends that were asked for */
  size_t column;                /* of the advantage, in the table */
  bool friction;                /* some joint has friction: the next column is the actual force ratio */
  km_advantage_method method;   /* of the first row */
  km_advantage_toggle *toggles; /* in the order of the sweep */
  size_t toggle_count;
  km_transmission last; /* of the last row, with why metrics are undefined there; if the transmission was asked for */
  km_peak lowest, highest; /* of the advantage, between the rows too; infinite beside a toggle */
  km_peak least;           /* its value of the least size, between the rows too */
} km_advantage_sweep;

/* Sweeps as km_mobility_sweep_run does, and looks between the rows for toggles of the advantage (to 1e-9 of the
 * driver) and for its extremes. `transmission` adds the metrics of kmech/transmission.h as columns. KM_USAGE: the ends
 * can't be input and output (km_transfer_create). Names of the ends are borrowed by `out`. Free `*out` in any case. */
KM_API km_status km_advantage_sweep_run(const km_mechanism *mechanism, km_state *state, const km_sweep_plan *plan,
                                        const km_port *input, const km_port *output, bool transmission,
                                        km_advantage_sweep *out, km_error *error);
KM_API void km_advantage_sweep_free(km_advantage_sweep *sweep);

/* ---- Static balance over a sweep. */

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
  km_port *actuators;     /* [actuator] */
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

/* ---- Redundant constraints over a whole sweep: which stay, and where there are more. */

/* A pose of the sweep with more redundant constraints than the others, and as much more mobility. */
typedef struct km_extra_redundancy {
  double s; /* where: the driver, or arc length */
  int more; /* how many more redundant constraints */
} km_extra_redundancy;

/* What is constrained twice along a sweep. */
typedef struct km_sweep_redundancies {
  km_redundancies persistent; /* if asked for: named at a pose of the least mobility, redundant at every pose */
  km_extra_redundancy *extra; /* rows and branch points, by s in the order of the sweep */
  size_t extra_count;
} km_sweep_redundancies;

/* From the rows of a sweep: the rank of each pose says how many constraints are redundant there (6 · loops + couplings
 * − rank). `named`: the lasting ones are named too, on a state of its own. Free `*out` in any case. */
KM_API km_status km_sweep_redundancies_find(const km_mechanism *mechanism, const km_sweep *sweep, bool named,
                                            km_sweep_redundancies *out, km_error *error);
KM_API void km_sweep_redundancies_free(km_sweep_redundancies *redundancies);

#ifdef __cplusplus
}
#endif
#endif
