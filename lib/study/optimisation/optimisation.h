/* Optimisation by NLopt. Private to study/. */
#ifndef KM_STUDY_OPTIMISATION_OPTIMISATION_H
#define KM_STUDY_OPTIMISATION_OPTIMISATION_H

#include "study/design_study.h"

/* Checks the name of an algorithm. KM_USAGE with the closest names. */
km_status km_algorithm_check(const char *word, km_error *error);

/* Optimises from every start, each on one thread, and lists the designs in the study's trail. `compute` false: only
 * as far as the store has answers. */
km_status km_optimise_run(km_design_study *study, int jobs, bool compute, km_progress progress, void *context,
                          km_error *error);

#endif
