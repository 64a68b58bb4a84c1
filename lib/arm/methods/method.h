/* The methods' common interface: a run in, the samples that were reached out. One file a method. */
#ifndef KM_ARM_METHODS_METHOD_H
#define KM_ARM_METHODS_METHOD_H

#include "arm/tracking/tracker.h"
#include "base/parallel.h"

typedef struct km_entry_range {
  const km_arm *arm;
  const km_track_plan *plan;
  km_tracker walk;
  km_tracker_space space;
  km_arena arena;
  km_node node, next; /* of km_run_steps */
  double *start;      /* [n] */
  double *q;          /* [samples × n] */
  int reached;        /* samples in q */
  double *last;       /* [n] where the track ends between samples */
  double fraction;    /* of the interval after the last sample; 0: it ends on the sample */
  km_track_stop stop;
  int column;
  bool held[KM_ARM_MOST]; /* fixed: columns that don't move */
  bool greedy_instead;
  double converged;
  bool bounded;              /* dp: its states or tilts were fewer than the spacing asks for */
  unsigned long evaluations; /* of other workspaces than `space` */
  km_team *team;             /* km_run_team */
} km_entry_range;

bool km_run_create(const km_arm *arm, const km_track_plan *plan, km_entry_range *run);
void km_run_free(km_entry_range *run);
/* The threads that share the run's work, from the first time on that it is asked for; NULL: there is one thread. */
km_team *km_run_team(km_entry_range *run);
/* Takes the track of another run of the same plan over. */
void km_run_take(km_entry_range *run, const km_entry_range *other);

/* Runs a method from run->start. KM_PARTIAL: it doesn't come to the path's end. */
typedef km_status (*km_method_run)(km_entry_range *run, km_error *error);
km_status km_method_greedy(km_entry_range *run, km_error *error);
km_status km_method_lookahead(km_entry_range *run, km_error *error);
km_status km_method_fixed(km_entry_range *run, km_error *error);
km_status km_method_dls(km_entry_range *run, km_error *error);
km_status km_method_gradient(km_entry_range *run, km_error *error);
km_status km_method_dp(km_entry_range *run, km_error *error);
km_status km_method_global(km_entry_range *run, km_error *error);

/* Chooses the way on from a node at a sample; it may use the run's space. */
typedef void (*km_run_choose)(void *context, km_entry_range *run, int sample, const km_node *node, km_step_choice *way);
/* Step after step along the whole path, by the ways chosen (NULL: greedy's); `first` is the way at the start. */
km_status km_run_steps(km_entry_range *run, const km_step_choice *first, km_run_choose choose, void *context,
                       km_error *error);

/* The same without asking for progress or telling why it ends: KM_OK or KM_PARTIAL, for tracks that are only tried. */
km_status km_run_try(km_entry_range *run, const km_step_choice *first, km_run_choose choose, void *context);

/* The end of a track whose step from `node` on the last sample fails with `end`. */
void km_run_stop(km_entry_range *run, const km_node *node, const km_step_choice *way, km_step_end end);
/* Asks the progress callback; false: cancelled. */
bool km_run_goes_on(const km_entry_range *run, int sample);

/* Min and sum of the objective over the samples, at greedy's own columns; the rate margin is the track's. */
typedef struct km_run_value {
  double least, sum;
  int samples;
} km_run_value;
km_run_value km_run_evaluate(km_entry_range *run);
/* What counts of a track: min, or mean of path-control. */
double km_run_score(const km_entry_range *run, km_run_value value);

/* Without the digits that rounding may have changed, so that units and symmetric postures don't decide what an
 * optimisation prefers. */
static inline double km_run_rounded(double value) {
  return nearbyint(value * 0x1p33) * 0x1p-33;
}

#endif
