/* Search for all self-motion curves of configurations that reach a target pose. */
#ifndef KM_ARM_IK_IK_SEARCH_H
#define KM_ARM_IK_IK_SEARCH_H

#include "arm/ik/ik_branches.h"

typedef struct km_ik_search {
  const km_arm *arm;
  km_arm_space space;
  km_pose target;
  km_selfmotion_curve *curves; /* [count] curves; single configurations unless the arm has one spare freedom */
  size_t capacity;
  int count;
  int starts, converged; /* starts of Newton's method, and its solutions */
  int known_in_row;      /* known solutions in a row */
  bool has_families;     /* there are singular solutions of families larger than a curve */
  bool closed_form;      /* a closed form exists, and all its solutions are on the curves */
  bool confirmed;        /* the count is confirmed: by the closed form of six hinges, else by the evidence of the
                          * search */
  bool failed;           /* out of memory or cancelled */
  km_progress progress;  /* NULL: no progress calls */
  void *context;
  bool cancelled;
} km_ik_search;

/* Runs the search. KM_NO_RESULT: out of reach; KM_MEMORY; KM_CANCELLED. Free the search in any case. */
km_status km_ik_search_run(const km_arm *arm, const km_pose *target, unsigned long seed, km_progress progress,
                           void *context, km_ik_search *finder, km_error *error);
/* True if a branch is a single configuration with σ_min below 1e-5: it can be one of a family. */
bool km_ik_search_is_singular(km_ik_search *finder, int branch);
void km_ik_search_free(km_ik_search *finder);

#endif
