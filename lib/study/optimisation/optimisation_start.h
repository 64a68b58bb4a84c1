/* One start of an optimisation: what NLopt asks of it. Private to study/. */
#ifndef KM_STUDY_OPTIMISATION_OPTIMISATION_START_H
#define KM_STUDY_OPTIMISATION_OPTIMISATION_START_H

#include "study/design_evaluation.h"
#include "study/optimisation/algorithms.h"

#include <stdatomic.h>

/* What the starts of an optimisation share. */
typedef struct km_optimisation {
  km_design_study *study;
  const km_design_optimise *def;
  const km_algorithm *algorithm;
  bool compute;
  km_progress progress;
  const void *caller; /* km_thread_mark: the thread that called the library tells the progress */
  void *context;
  atomic_int evaluations; /* of all starts */
  atomic_bool stopped;
  int total;
} km_optimisation;

enum { KM_MAX_ATTEMPT_LIMITS = 2 * KM_MAX_DESIGN_FIGURES + 1 };

/* One start. */
typedef struct km_attempt {
  km_optimisation *o;
  int number;
  int goal;     /* that is to be least */
  bool between; /* for a point between the ends of a front: the second goal, with a limit that ties it to the first */
  double ideal[2], range[2]; /* of the front's ends */
  double apart; /* so much the first goal may be above the second, both counted from 0 to 1 from end to end */
  km_evaluation batch;
  nlopt_opt optimiser;
  double *values; /* [count × parameters] what was asked for */
  size_t room;
  int count;
  double worst;                          /* objective so far; a design that fails is worse than that */
  double slack[KM_MAX_ATTEMPT_LIMITS];   /* of the point that was asked last */
  double last[KM_MAX_DESIGN_PARAMETERS]; /* that point, scaled */
  double last_value;
  bool has_last;
  km_status status;
  km_error error;
} km_attempt;

/* How many limits the figures have, which are constraints, and the attempt itself. */
int km_attempt_limits(const km_attempt *attempt);
/* Has some point had an answer? */
bool km_attempt_knows(const km_attempt *attempt);
/* NLopt's functions, with an attempt as their context: the objective and the limits of the point x, scaled to 0 … 1 by the
 * variables' bounds, and where they are asked for the gradients by central differences. */
double km_attempt_evaluate(unsigned count, const double *x, double *gradient, void *attempt);
void km_attempt_constrain(unsigned limits, double *result, unsigned count, const double *x, double *gradient,
                          void *attempt);

#endif
