/* A search for all curves of poses that reach a target. */
#ifndef KM_ARM_IK_IK_SEARCH_H
#define KM_ARM_IK_IK_SEARCH_H

#include "arm/ik/ik_branches.h"

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
  bool failed;           /* out of memory, or cancelled */
  km_progress progress;  /* NULL: nobody asks */
  void *context;
  bool cancelled;
} km_finder;

/* KM_NO_RESULT: out of reach; KM_MEMORY; KM_CANCELLED. Free it in any case. */
km_status km_finder_run(const km_arm *arm, const km_pose *target, unsigned long seed, km_progress progress,
                        void *context, km_finder *finder, km_error *error);
/* Is a branch a single pose, and singular as far as Newton's method tells? Then it may be one of a family of poses. */
bool km_finder_is_singular(km_finder *finder, int branch);
void km_finder_free(km_finder *finder);

#endif
