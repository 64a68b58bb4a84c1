/* One start of an optimisation: its points, objective and constraints. Private to study/. */
#ifndef KM_STUDY_OPTIMISATION_OPTIMISATION_START_H
#define KM_STUDY_OPTIMISATION_OPTIMISATION_START_H

#include "study/design_evaluation.h"
#include "study/optimisation/algorithms.h"

#include <stdatomic.h>

/* Data shared by the starts of an optimisation. */
typedef struct km_optimisation {
  km_design_study *study;
  const km_design_optimise *def;
  const km_algorithm *algorithm;
  bool compute;
  km_progress progress;
  const void *caller; /* km_thread_mark of the calling thread, which reports the progress */
  void *context;
  atomic_int evaluations; /* evaluations of all starts */
  atomic_bool stopped;
  int total;
} km_optimisation;

enum { KM_MAX_ATTEMPT_LIMITS = 2 * KM_MAX_DESIGN_FIGURES + 1 };

/* One start of an optimisation. */
typedef struct km_attempt {
  km_optimisation *o;
  int number;
  int goal;                  /* goal to minimise */
  bool between;              /* point between the ends of a front: the second goal, constrained by the first */
  double ideal[2], range[2]; /* best values and ranges of the goals at the front's ends */
  double max_difference;     /* bound a of f_1 − f_2, both scaled to 0 … 1 */
  km_evaluation batch;
  nlopt_opt optimiser;
  double *values; /* [count × parameters] evaluated points */
  size_t capacity;
  int count;
  double worst;                             /* largest objective so far; a failed design counts as worse */
  double constraint[KM_MAX_ATTEMPT_LIMITS]; /* constraint values of the last point */
  double last[KM_MAX_DESIGN_PARAMETERS];    /* last point, scaled */
  double last_value;
  bool has_last;
  km_status status;
  km_error error;
} km_attempt;

/* Number of constraints: limits of figures, plus one between the ends of a front. */
int km_attempt_limits(const km_attempt *attempt);
/* True if some point had an answer. */
bool km_attempt_has_value(const km_attempt *attempt);
/* Functions for NLopt, with a start as context: objective and constraints at the point x, scaled to 0 … 1 by the
 * variables' bounds, with gradients by central differences if requested. */
double km_attempt_evaluate(unsigned count, const double *x, double *gradient, void *attempt);
void km_attempt_constrain(unsigned limits, double *result, unsigned count, const double *x, double *gradient,
                          void *attempt);

#endif
