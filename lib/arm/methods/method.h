/* Common interface of the tracking methods: a run as input, the samples that were reached as output. Each method
 * has one file. */
#ifndef KM_ARM_METHODS_METHOD_H
#define KM_ARM_METHODS_METHOD_H

#include "arm/tracking/tracker.h"
#include "base/parallel.h"

typedef struct km_tracking_run {
  const km_arm *arm;
  const km_track_plan *plan;
  km_tracker tracker;
  km_tracker_space space;
  km_arena arena;
  km_path_node node, next; /* nodes of km_run_steps */
  double *start;           /* [n] */
  double *q;               /* [samples × n] */
  int reached;             /* samples in q */
  double *last;            /* [n] configuration at the end of the track, if between samples */
  double fraction; /* part of the interval after the last sample that is covered; 0: the track ends on the sample */
  km_track_stop stop;
  int column;
  bool fixed[KM_ARM_MAX_JOINTS]; /* method fixed: joints that don't move */
  bool greedy_instead;
  double converged;
  bool bounded;              /* dp: the numbers of states or actions were limited, so they are coarser than the
                              * spacing */
  unsigned long evaluations; /* Jacobians of workspaces other than `space` */
  km_team *team;             /* km_run_team */
} km_tracking_run;

bool km_run_create(const km_arm *arm, const km_track_plan *plan, km_tracking_run *run);
void km_run_free(km_tracking_run *run);
/* The threads of the run, created at the first call; NULL: one thread. */
km_team *km_run_team(km_tracking_run *run);
/* Copies the track of another run of the same plan. */
void km_run_copy_track(km_tracking_run *run, const km_tracking_run *other);

/* A method: computes the track from run->start. KM_PARTIAL: the track ends before the path. */
typedef km_status (*km_method_function)(km_tracking_run *run, km_error *error);
km_status km_method_greedy(km_tracking_run *run, km_error *error);
km_status km_method_lookahead(km_tracking_run *run, km_error *error);
km_status km_method_fixed(km_tracking_run *run, km_error *error);
km_status km_method_dls(km_tracking_run *run, km_error *error);
km_status km_method_gradient(km_tracking_run *run, km_error *error);
km_status km_method_dp(km_tracking_run *run, km_error *error);
km_status km_method_global(km_tracking_run *run, km_error *error);

/* Chooses the next step from a node at a sample; may use the run's workspace. */
typedef void (*km_run_choose)(void *context, km_tracking_run *run, int sample, const km_path_node *node,
                              km_step_choice *choice);
/* Advances along the path sample by sample, with the steps that `choose` returns (NULL: always `first`). */
km_status km_run_steps(km_tracking_run *run, const km_step_choice *first, km_run_choose choose, void *context,
                       km_error *error);

/* As km_run_steps, without progress and without the location of the end; for trial tracks. KM_OK or KM_PARTIAL. */
km_status km_run_try(km_tracking_run *run, const km_step_choice *first, km_run_choose choose, void *context);

/* Locates and classifies the end of a track whose step from `node` at the last sample failed with `end`. */
void km_run_stop(km_tracking_run *run, const km_path_node *node, const km_step_choice *choice, km_step_end end);
/* Calls the progress callback; false: cancelled. */
bool km_run_report_progress(const km_tracking_run *run, int sample);

/* Minimum and sum of the objective over the samples. The columns are those of the path control; the rate margin is
 * that of the track's own rates. */
typedef struct km_run_value {
  double least, sum;
  int samples;
} km_run_value;
km_run_value km_run_evaluate(km_tracking_run *run);
/* Score of a track: minimum of the objective, mean for path-control. */
double km_run_score(const km_tracking_run *run, km_run_value value);

/* Rounds to multiples of 2⁻³³, so that rounding errors don't decide between equivalent tracks. */
static inline double km_run_rounded(double value) {
  return nearbyint(value * 0x1p33) * 0x1p-33;
}

#endif
