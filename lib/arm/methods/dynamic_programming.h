/* Dynamic programming's states: what the stages, the search and the choice of the best share. */
#ifndef KM_ARM_METHODS_DYNAMIC_PROGRAMMING_H
#define KM_ARM_METHODS_DYNAMIC_PROGRAMMING_H

#include "arm/methods/method.h"

typedef struct km_dp_state {
  double least, sum;
  int parent;  /* in the stage before */
  int samples; /* reached since the start */
  double *q;   /* [stage length × n] of the stage that ends here */
  km_node node;
} km_dp_state;

typedef struct km_dp_stage {
  km_dp_state *states;
  int count, first, length; /* samples first + 1 … first + length */
} km_dp_stage;

typedef struct km_dp_grid {
  km_entry_range *run;
  km_arena arena;
  double spacing;
  bool eased; /* tilts turn back as far as the rates ask */
  bool bounded;
  int pass, passes; /* for the progress */
  int length, stage_count, actions, workers;
  km_dp_stage *stages;
  int now;               /* the stage being filled */
  double *tilts;         /* [actions × freedom] */
  km_dp_state *arrivals; /* [states · actions] */
  size_t arrival_capacity;
  km_tracker_space *spaces;
  km_node *here;
} km_dp_grid;

/* Is a better than b: further, then the value, then the other aggregate? */
bool km_dp_better(const km_dp_grid *grid, const km_dp_state *a, const km_dp_state *b);
/* A state with room for a stage of that length; the grid's arena tells if there is no memory. */
km_dp_state km_dp_make_state(km_dp_grid *grid, int length);
/* Of the arrivals the best of each neighbourhood, into the states of the stage being filled. False: out of memory. */
bool km_dp_keep_best(km_dp_grid *grid, int arrived);

#endif
