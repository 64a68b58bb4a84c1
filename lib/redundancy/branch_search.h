/* A search for all curves of poses that reach a target. */
#ifndef KM_REDUNDANCY_BRANCH_SEARCH_H
#define KM_REDUNDANCY_BRANCH_SEARCH_H

#include "redundancy/branches.h"

typedef struct km_finder {
  const km_arm *arm;
  km_arm_space space;
  km_pose target;
  km_loop_curve *curves; /* [count]; single poses where the arm has no freedom to spare or several */
  size_t capacity;
  int count;
  int starts, converged; /* of Newton's method, and its solutions */
  int idle;              /* solutions in a row that were known */
  bool families;         /* singular poses that fill more than a curve are among them */
  bool closed_form;      /* there is one, and every solution that it has is on the curves */
  bool confirmed;        /* the count is: of six hinges in closed form, else by the search's own evidence */
  bool failed;           /* out of memory */
} km_finder;

/* KM_PARTIAL: out of reach; KM_MEMORY. Free it in any case. */
km_status km_finder_run(const km_arm *arm, const km_pose *target, unsigned long seed, km_finder *finder,
                        km_error *error);
/* Has the arm more directions at q than it has to spare? Such singular poses may fill more than their curve. */
bool km_finder_is_singular(km_finder *finder, const double *q);
void km_finder_free(km_finder *finder);

#endif
