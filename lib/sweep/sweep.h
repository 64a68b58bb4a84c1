/* Sweeps (theory 10): a mover advances the mechanism from row to row, an observer writes columns and finds events.
 * Private to the library. */
#ifndef KM_SWEEP_SWEEP_H
#define KM_SWEEP_SWEEP_H

#include "base/memory.h"
#include "continuation/arc_motion.h"
#include "continuation/batch/batch.h"
#include "kmech/sweep.h"

/* Mover: advances the mechanism by a driver or by arc length; s is the driver's value or the arc length. */
typedef struct km_mover {
  void *self;
  /* Computes the rates of all coordinates per unit of s at the row; false if there is no direction of motion. */
  bool (*rates)(void *self, double *rates);
  /* Moves the state to another s near the row and computes the rates there; `restore` returns to the row exactly. */
  bool (*probe)(void *self, double s, double *rates);
  void (*restore)(void *self);
  /* Stores the present configuration as a start for later probes, so that with several freedoms they follow the path
   * that led on. False without memory; NULL: the return path is unique. */
  bool (*pass)(void *self);
  /* Writes the unit direction of motion by coordinates; in a batch, with one freedom. */
  void (*direction)(void *self, double *z);
} km_mover;

typedef struct km_sweeper km_sweeper;
typedef struct km_sweep_job km_sweep_job;

/* Observer of a sweep: mobility numbers, mechanical advantage, forces. Functions but `columns`, `cells`, `finish` and
 * `close` may be NULL. */
typedef struct km_observer {
  void *self;
  bool (*columns)(void *self, const km_sweeper *sweeper, km_table *table); /* adds its columns; false: no memory */
  /* Writes the cells of its columns at the row's configuration and returns the next cell. Partition and null space of
   * the moving substructure are valid. */
  double *(*cells)(void *self, km_sweeper *sweeper, double *cell);
  /* After each row, or after some (see number_cells): finds the events since the last one. Leaves the state at the
   * row. */
  km_status (*row_written)(void *self, km_sweeper *sweeper, double s, km_error *error);
  /* The motion took a step to s between rows, with these rates. The state can be elsewhere; some reported steps are
   * only attempted. */
  void (*step_taken)(void *self, const km_sweeper *sweeper, double s, const double *rates);
  /* After row_written: returns the next s near the row at which the observer needs the rates; false: none. `probed`
   * then passes the rates, NULL if the motion does not reach s. */
  bool (*next_probe)(void *self, double *s);
  km_status (*probed)(void *self, km_sweeper *sweeper, const double *rates, km_error *error);
  /* Samples a configuration between rows, at distances that resolve the functions; NULL: no samples are taken. */
  km_status (*sampled_between)(void *self, km_sweeper *sweeper, double s, km_error *error);
  /* The motion switches to another branch: directions before and after it are unrelated. */
  void (*corner)(void *self);
  /* The motion ends at s, a turning point of the driver. */
  km_status (*end_reached)(void *self, km_sweeper *sweeper, double s, km_error *error);
  /* After the last row, if the job's status is KM_OK or KM_PARTIAL: concludes from all rows. Returns the job's new
   * status. */
  km_status (*finish)(void *self, const km_sweep_job *job);
  void (*close)(void *self); /* frees the observer */
  /* Reads the state's Jacobian and partition besides coordinates, mobility numbers, rates and residual. */
  bool reads_jacobian;
  bool reads_basis;    /* reads the null space only, */
  bool uses_direction; /* but uses km_mover.direction with one freedom */
  /* Observers of zeros of the direction of motion only (else NULL): the cell of each coordinate's mobility number in
   * a row, 0: none. A batch passes rows without a zero between them. Only the last two of these are reported by
   * row_written; in the others only coordinates, mobility numbers and the residual are new. All rows are passed if
   * row_written is NULL. */
  const size_t *number_cells;
  /* Columns that are not read, by coordinate, with number_cells; NULL: all are. Cells of passed rows are then
   * undefined, and branch points between rows are not searched. */
  const bool *unread;
} km_observer;

/* Data of one sweep. */
struct km_sweeper {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
  const km_observer *observer;
  km_sweep *out;
  km_mover mover;
  int substructure; /* the moving substructure, -1: none */
  double *rates;    /* [coordinate] */
  double *scratch;  /* [coordinate] */
  /* configuration of the first row if it is a branch point with several freedoms; NULL: regular */
  double *branch_first_row;
  bool is_batched;       /* the row was reached in a batch, and the state has its mobility numbers: */
  bool is_passed_row;    /* the motion has passed the row already, so that it cannot be probed */
  double residual;       /* residual of the moving loops, in a batch */
  double other_residual; /* residual of the other substructures */
  int other_mobility;
};

/* Least number of samples over the whole range, and the longest arc between them. */
enum { KM_MIN_SAMPLES = 360 };
#define KM_LONGEST_ARC 0.02
/* Least step by arc length, from the digits of a configuration. */
#define KM_MIN_ARCLENGTH 1e-8

/* True if a driver moves the mechanism; else arc length, or nothing. */
static inline bool km_plan_is_driven(const km_sweep_plan *plan) {
  return plan->steps > 0 && !(plan->arclength > 0.0);
}

/* Sign of s along the sweep. */
static inline double km_sweep_sense(const km_sweep_plan *plan) {
  return km_plan_is_driven(plan) && plan->to < plan->from ? -1.0 : 1.0;
}

/* Memory of an earlier sweep, which the next one takes and returns, except for its result. */
typedef struct km_sweep_workspace {
  km_table *table; /* NULL: a new one is created */
  km_arena motion, lanes;
} km_sweep_workspace;
void km_sweep_workspace_free(km_sweep_workspace *workspace);

/* One of several sweeps. The analysis sets `observer`, `out` and, on failure, `status`: see sweep_observer.h. */
struct km_sweep_job {
  const km_mechanism *m;
  km_state *s; /* owned by the job alone */
  const km_sweep_plan *plan;
  km_sweep_workspace *workspace; /* NULL: none */
  km_error *error;               /* may be NULL */
  const km_observer *observer;
  km_sweep *out;
  /* Only the rows and the end of the motion are read: events between rows are not searched, and the state's partition
   * is not kept. */
  bool table_only;
  const char *const
      /* names of the columns that are read, NULL-terminated, with table_only; others can be omitted. NULL: all */
      *read_columns;
  km_status status; /* result */
};

/* Runs up to KM_BATCH_LANES sweeps from assembled states; see km_mobility_sweep_run. Driven ones advance in a batch,
 * with the bits of single ones. Jobs with a status are skipped. Closes the observers. Free the results in any case. */
void km_sweeps_run(km_sweep_job *jobs, int count);

/* Checks the arguments of a public sweep function: KM_USAGE. */
km_status km_check_sweep(const km_mechanism *mechanism, const km_state *state, const km_sweep_plan *plan,
                         km_error *error);

km_status km_sweeper_columns(const km_sweeper *sweeper, km_error *error);
/* Computes the numbers of the substructures at rest, and the passive freedoms. KM_MEMORY. */
km_status km_sweeper_prepare(km_sweeper *sweeper, km_error *error);
/* Writes the single row of a sweep without motion. KM_MEMORY, and errors of the observer. */
km_status km_sweeper_single_row(km_sweeper *sweeper, km_error *error);
/* Returns the observer of the motion's steps, if the sweep's observer has step_taken. `sweeper` must stay valid. */
km_step_observer km_sweeper_step_observer(km_sweeper *sweeper);
/* Writes a row at the state's configuration and reports it to the observer; and runs the probes that the observer
 * requests. */
km_status km_sweeper_row(km_sweeper *sweeper, int step, double s, km_error *error);
km_status km_sweeper_near_row(km_sweeper *sweeper, km_error *error);

/* Appends the first `count` of the rows that a batch has passed; see km_observer.number_cells. `step` and s[row ×
 * KM_BATCH_LANES] are those of the first. */
km_status km_sweeper_passed_rows(km_sweeper *sweeper, const km_driver_motion *drive, int count, int step,
                                 const double *s, km_error *error);
/* Writes a row between rows, with the motion r->rates, into the sweep's `between`. False without memory. */
bool km_sweeper_write_between(km_sweeper *sweeper, double s);
/* Functions vary as √s' near a turning point. Samples k = 1, 2, … between s and the end, at geometrically decreasing
 * distances (factor 4). */
enum { KM_END_SAMPLES = 12 };
double km_sweeper_end_sample(double s, double end, int k);
/* Interval between two rows; is_first: it begins at the start of the motion, is_last: it ends at the last row. */
typedef struct km_row_interval {
  double from, to;
  bool is_first, is_last;
} km_row_interval;
/* Number of parts of an interval for KM_MIN_SAMPLES over the range; and the end of part k, 0: the interval's start. */
int km_sweeper_interval_parts(const km_sweeper *sweeper);
double km_sweeper_part_end(double from, double to, int k, int parts);
/* Samples the observer's functions between the parts of an interval, and more densely near the start and the end of
 * the motion. The motion is at the start of part `first` (from 1); it continues to the last sample or, if nothing
 * ends it, to the row. */
km_status km_sweeper_sample_to_row(km_sweeper *sweeper, km_driver_motion *drive, const km_row_interval *way, int first,
                                   km_error *error);
/* True if the configuration, whose factor is current, has more freedoms than the motion: a branch point. */
static inline bool km_sweeper_has_more_freedoms(const km_sweeper *r) {
  return r->substructure >= 0 && km_factor_freedom(r->s->factor[r->substructure]) > r->out->freedom;
}
/* Updates the motions, then as km_sweeper_has_more_freedoms. */
bool km_sweeper_is_at_branch_point(km_sweeper *sweeper);

/* Updates the motions of the moving substructure, unless the row was reached in a batch. */
void km_sweeper_update_motions(km_sweeper *sweeper);
/* Returns the rates of the single freedom in a batch, from its unit direction, in r->scratch. */
const double *km_sweeper_batched_rates(const km_sweeper *sweeper);
/* Computes the rates r->rates and the null space of the configuration; computing rates can leave the null space with
 * a fixed driver behind. False if there is no direction of motion. */
bool km_sweeper_update_rates(km_sweeper *sweeper);

/* Adds a branch point to the sweep. KM_MEMORY. */
km_status km_sweeper_add_branch(km_sweeper *sweeper, km_branch_point point, km_error *error);
/* Finds the branches at the state's configuration: their number and directions [KM_MAX_BRANCHES × columns]; 0 if
 * fewer than two are found. KM_MEMORY. */
km_status km_sweeper_find_branch_directions(const km_sweeper *sweeper, km_state *state, double *directions, int *count,
                                            km_error *error);
/* Locates the branch point that the motion passed before the last row, and its branches. */
km_status km_sweeper_find_branch(km_sweeper *sweeper, km_error *error);
/* Leaves a branch point at the start by a short step onto the branch that moves the plan's coordinate fastest; with
 * several freedoms `branch_first_row` becomes the first row. KM_MEMORY. */
km_status km_sweeper_leave_branch(km_sweeper *sweeper, km_error *error);

/* Run driven sweeps in a batch, and one sweep by arc length. sweepers[i] belongs to jobs[i]; jobs with a status are
 * skipped. */
void km_sweeps_by_driver(km_sweeper *sweepers, km_sweep_job *jobs, int count);
km_status km_sweep_by_length(km_sweeper *sweeper, km_error *error);

/* Extends a swing to a value at s; swing of a coordinate over the rows of a sweep; and with the values at its dead
 * points. */
void km_swing_take(km_swing *swing, double value, double s);
km_swing km_swing_over_rows(const km_mechanism *mechanism, const km_table *table, int coordinate);
km_swing km_swing_with_toggles(const km_mechanism *mechanism, const km_mobility_sweep *sweep, int coordinate);

/* Calls the progress callback; false: cancelled. */
static inline bool km_sweeper_continues(const km_sweeper *r, int step) {
  return !r->plan->progress || r->plan->progress(r->plan->context, (double)step / r->plan->steps);
}

#endif
