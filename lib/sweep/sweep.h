/* The parts of a sweep: what moves the mechanism from row to row, and what looks at it there. Private to analysis/. */
#ifndef KM_SWEEP_SWEEP_H
#define KM_SWEEP_SWEEP_H

#include "base/memory.h"
#include "continuation/batch/batch.h"
#include "kmech/sweep.h"

/* How the mechanism moves from row to row: by a driver or by arc length. */
typedef struct km_mover {
  void *self;
  /* Rates of all coordinates per unit of s at the row; false where there is no direction. */
  bool (*rates)(void *self, double *rates);
  /* The same at another s near the row, where the state then stands; `settle` comes back to the row. */
  bool (*probe)(void *self, double s, double *rates);
  void (*settle)(void *self);
  /* The row, or a pose on the way to it, is one from which `probe` sets out to places behind it, so that it finds those of the
   * way that led on. False when out of memory; NULL: every way back is that way. */
  bool (*pass)(void *self);
  /* Where the sweeper rides and one freedom is left: the unit direction of motion by coordinates. */
  void (*direction)(void *self, double *z);
} km_mover;

typedef struct km_sweeper km_sweeper;
typedef struct km_sweep_job km_sweep_job;

/* What is looked at: mobility numbers, leverage, forces. Any function but `columns`, `cells`, `tell` and `close` may be NULL. */
typedef struct km_observer {
  void *self;
  bool (*columns)(void *self, const km_sweeper *sweeper, km_table *table); /* false: out of memory */
  /* Writes the cells of its columns at the row's pose, and returns the one behind them. The moving substructure has
   * its partition and null space. */
  double *(*cells)(void *self, km_sweeper *sweeper, double *cell);
  /* After each row, or just after some: see number_cells. What lies between it and the last one. Leaves the state at the row. */
  km_status (*seen)(void *self, km_sweeper *sweeper, double s, km_error *error);
  /* The motion has made a step between rows, on its own, to s, where it has these rates; the state needn't stand there when this
   * is told, and some steps are told that were only tried. */
  void (*stepped)(void *self, const km_sweeper *sweeper, double s, const double *rates);
  /* Behind `seen`: a place near the row at which the observer wants to know the rates, false: at none; and those rates, NULL
   * where the motion doesn't get there. `shown` comes after each place that is wanted. */
  bool (*wants)(void *self, double *s);
  km_status (*shown)(void *self, km_sweeper *sweeper, const double *rates, km_error *error);
  /* At poses between rows, close enough to show what happens there; an observer without it isn't shown any. */
  km_status (*passed)(void *self, km_sweeper *sweeper, double s, km_error *error);
  /* The motion turns a corner: directions before and after it have nothing to do with each other. */
  void (*corner)(void *self);
  /* The driver itself gives out at s. */
  km_status (*ended)(void *self, km_sweeper *sweeper, double s, km_error *error);
  /* Behind the last row, where the job's status is KM_OK or KM_PARTIAL: what is found from all rows. The status from now on. */
  km_status (*tell)(void *self, const km_sweep_job *job);
  void (*close)(void *self); /* frees the observer */
  /* Looks at more than coordinates, mobility numbers, rates and residual: the state's Jacobian and partition. */
  bool reads_jacobian;
  bool reads_basis;    /* and at the null space alone, */
  bool asks_direction; /* but asks km_mover.direction where one freedom is left */
  /* Of an observer that looks for places where an entry of the direction of motion is 0, and for nothing else: the cell of each
   * coordinate's mobility number in a row, 0: none. Of rows (km_sweeper.passed) between which no entry comes near 0 only the last two have to be
   * `seen`, and in the others only coordinates, mobility numbers and the residual are new; where `seen` is NULL that holds of
   * all rows. Else NULL. */
  const size_t *number_cells;
  /* With number_cells: of each coordinate, whether nobody reads its column; NULL: all are read. In rows that are passed its cell
   * holds anything then, and branch points between rows, which are looked for from a row, aren't looked for. */
  const bool *unread;
} km_observer;

/* Everything that one sweep needs at hand. */
struct km_sweeper {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
  const km_observer *observer;
  km_sweep *out;
  km_mover mover;
  int substructure;     /* the one that moves, -1: none */
  double *rates;        /* [coordinate] */
  double *scratch;      /* [coordinate] */
  double *branch_point; /* saved: the first row's pose, where several freedoms lead away from it; NULL: it is regular */
  bool rides;           /* the row was reached beside others, and the state has its mobility numbers already: */
  bool passed;          /* and the drive stands behind it already, so that no place near it can be visited */
  double residual;      /* of the loops that move, then */
  double other_residual; /* of the substructures that stand still */
  int other_mobility;
};

/* Poses that an observer sees at least over the whole range, and the longest arc between them. */
enum { KM_LEAST_SAMPLES = 360 };
#define KM_LONGEST_ARC 0.02
/* Of a step by arc length: more than what the poses' own digits show, and what takes a moment. */
#define KM_LEAST_ARCLENGTH 1e-8
#define KM_MAX_ARCLENGTH   1000.0

/* Does a driver move it, rather than the arc length or nothing? */
static inline bool km_plan_is_driven(const km_sweep_plan *plan) {
  return plan->steps > 0 && !(plan->arclength > 0.0);
}

/* Memory of an earlier sweep for the next one, which takes it and gives back what doesn't belong to its result. */
typedef struct km_sweep_workspace {
  km_table *table; /* NULL: a new one is made */
  km_arena drive, lanes;
} km_sweep_workspace;
void km_sweep_workspace_free(km_sweep_workspace *room);

/* One of several sweeps. What it looks at sets `observer` and `out`, and a status where it can't: see sweep_observer.h. */
struct km_sweep_job {
  const km_mechanism *m;
  km_state *s; /* of its own */
  const km_sweep_plan *plan;
  km_sweep_workspace *room; /* NULL: none */
  km_error *error;          /* may be NULL */
  const km_observer *observer;
  km_sweep *out;
  /* Nobody reads more than rows and how the motion ended: what lies between rows isn't looked for, and the state's
   * partition is left behind. */
  bool table_only;
  const char *const
      *reads; /* with table_only: names of columns, NULL behind them; others may be left out. NULL: all are read */
  km_status status; /* how it ended */
};

/* Moves the assembled states of up to KM_BATCH_LANES jobs over their plans' ranges; see km_mobility_sweep_run. Those by a driver
 * go side by side, with the same bits. Jobs that have a status already aren't begun. Closes the observers. Free what they have
 * found in any case. */
void km_sweeps_run(km_sweep_job *jobs, int count);

/* For public functions: KM_USAGE unless the state is the mechanism's and the plan one for it. */
km_status km_check_sweep(const km_mechanism *mechanism, const km_state *state, const km_sweep_plan *plan,
                         km_error *error);

km_status km_sweeper_columns(const km_sweeper *sweeper, km_error *error);
/* The numbers of what stands still, once, and which freedoms are idle. KM_MEMORY. */
km_status km_sweeper_prepare(km_sweeper *sweeper, km_error *error);
/* Who is to be told of the motion's steps: its observer, if it asks for them. `sweeper` has to stay. */
km_step_observer km_sweeper_step_watch(km_sweeper *sweeper);
/* A row at the state's pose, shown to the observer; and the places near it that the observer wants. */
km_status km_sweeper_row(km_sweeper *sweeper, int step, double s, km_error *error);
km_status km_sweeper_near_row(km_sweeper *sweeper, km_error *error);

/* The first `count` of the quiet rows that the drive has passed, behind the last one of the table. See
 * km_observer.number_cells. `step` and s[row × KM_BATCH_LANES] of the first of them. */
km_status km_sweeper_passed_rows(km_sweeper *sweeper, const km_driver_motion *drive, int count, int step,
                                 const double *s, km_error *error);
/* A row at a pose between rows, where r->rates is the motion: into the sweep's `between`. False when out of memory. */
bool km_sweeper_between(km_sweeper *sweeper, double s);
/* Functions may turn close to an end of the motion, where a driver gives out as the root of the way: places k = 1, 2, …
 * between s and it, each nearer to the end, at which the observer looks too. */
enum { KM_END_PLACES = 12 };
double km_sweeper_near_end(double s, double end, int k);
/* The way from a row to the next one, and whether the first row is its beginning or the last row its end. */
typedef struct km_sweep_way {
  double from, to;
  bool begins, ends;
} km_sweep_way;
/* It has so many parts, so that the observer sees KM_LEAST_SAMPLES poses of the range; and where part k ends, 0: begins. */
int km_sweeper_parts(const km_sweeper *sweeper);
double km_sweeper_part(double from, double to, int k, int parts);
/* Shows the observer the poses between the parts of a way, and more of them near where the motion begins or ends. The drive
 * stands where part `first` begins, from 1; it goes on to the last of the poses or, where nothing ends the motion, to the row. */
km_status km_sweeper_pass(km_sweeper *sweeper, km_driver_motion *drive, const km_sweep_way *way, int first,
                          km_error *error);
/* Does the state stand where several motions meet? No pose next to it is well known. */
bool km_sweeper_meets(km_sweeper *sweeper);

/* The motion at the state's pose into `rates`, with the null space of the pose up to date: finding a motion may leave
 * that of the coordinates beside the driver behind. False where there is no direction. */
bool km_sweeper_motion(km_sweeper *sweeper);

/* Lists a branch point. KM_MEMORY. */
km_status km_sweeper_add_branch(km_sweeper *sweeper, km_branch_point point, km_error *error);
/* How many motions meet at the state's pose, and their directions [KM_MAX_BRANCHES × columns]; 0 where fewer than two are
 * found, so that nothing is known of them. KM_MEMORY. */
km_status km_sweeper_look_at_branch(const km_sweeper *sweeper, km_state *state, double *directions, int *count,
                                    km_error *error);
/* The drive has passed a singular pose on the way to the last row: finds where, and what meets there. */
km_status km_sweeper_find_branch(km_sweeper *sweeper, km_error *error);
/* At a branch point no direction is the mechanism's own: a short step leads onto the motion that moves the plan's coordinate
 * most, from where the branch point can be passed smoothly, or (branch_point) which begins there. KM_MEMORY. */
km_status km_sweeper_leave_branch(km_sweeper *sweeper, km_error *error);

/* The rows of driven sweeps side by side, and of one by arc length. Of jobs[i] the sweeper is sweepers[i]; those with a
 * status are over already. */
void km_sweeps_by_driver(km_sweeper *sweepers, km_sweep_job *jobs, int count);
km_status km_sweep_by_length(km_sweeper *sweeper, km_error *error);

/* Asks the progress callback; false: cancelled. */
static inline bool km_sweeper_goes_on(const km_sweeper *r, int step) {
  return !r->plan->progress || r->plan->progress(r->plan->context, (double)step / r->plan->steps);
}

#endif
