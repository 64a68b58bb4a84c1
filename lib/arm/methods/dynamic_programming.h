/* States, stages and grid of dynamic programming. */
#ifndef KM_ARM_METHODS_DYNAMIC_PROGRAMMING_H
#define KM_ARM_METHODS_DYNAMIC_PROGRAMMING_H

#include "arm/methods/method.h"

typedef struct km_dp_state {
  double least, sum;
  int parent;  /* index of the parent in the previous stage */
  int samples; /* samples reached since the start */
  double *q;   /* [stage length × n] configurations of the stage that ends here */
  km_path_node node;
} km_dp_state;

typedef struct km_dp_stage {
  km_dp_state *states;
  int count, first, length; /* samples first + 1 … first + length */
} km_dp_stage;

typedef struct km_dp_grid {
  km_tracking_run *run;
  km_arena arena;
  double spacing;
  bool eased; /* steps are eased to satisfy the rates */
  bool bounded;
  int pass, passes; /* pass index and number, for the progress */
  int length, stage_count, actions, workers;
  km_dp_stage *stages;
  int now;               /* stage under construction */
  double *tan_phis;      /* [actions × freedom] */
  km_dp_state *arrivals; /* [states · actions] */
  size_t arrival_capacity;
  km_tracker_space *spaces;
  km_path_node *here;
} km_dp_grid;

/* True if a is better than b: more samples, then the objective's aggregate (minimum or sum), then the other
 * aggregate. */
bool km_dp_better(const km_dp_grid *grid, const km_dp_state *a, const km_dp_state *b);
/* Allocates a state for a stage of that length; on failure the grid's arena is marked as failed. */
km_dp_state km_dp_make_state(km_dp_grid *grid, int length);
/* Copies the best arrival of each neighbourhood to the states of the current stage. False: out of memory. */
bool km_dp_keep_best(km_dp_grid *grid, int arrived);

#endif
